//! Instruction sets as proofs that the machine has them, and values in their lanes that cannot be used without such a proof.
//!
//! Owns the contract between lanes and the code that works with them; detects and computes nothing.

/// A set of vector instructions that the machine has. A value of the type is the proof of that: only detection makes one.
pub(crate) trait Instructions: Copy + Send + Sync + 'static {
    /// Calls `work` with `value` in a function that is compiled for these instructions. `work` and the functions that it calls
    /// are compiled for them, too, if they are `#[inline(always)]`; everything that takes long must be so.
    fn carry_out<T, U>(self, value: T, work: impl FnOnce(T) -> U) -> U;
}

/// The instructions that every machine of the target has.
#[derive(Clone, Copy)]
pub(crate) struct Portable;

impl Instructions for Portable {
    #[inline(always)]
    fn carry_out<T, U>(self, value: T, work: impl FnOnce(T) -> U) -> U {
        work(value)
    }
}

/// A value in lanes of the instructions `I`. It is made and used only inside [`Instructions::carry_out`].
pub(crate) struct Held<I, T> {
    instructions: I,
    value: T,
}

impl<I: Instructions, T> Held<I, T> {
    pub fn new(instructions: I, make: impl FnOnce() -> T) -> Self {
        Self {
            instructions,
            value: instructions.carry_out((), |()| make()),
        }
    }

    #[inline(always)]
    pub fn with<U>(&self, work: impl FnOnce(&T) -> U) -> U {
        self.instructions.carry_out(&self.value, work)
    }

    #[inline(always)]
    pub fn with_mut<U>(&mut self, work: impl FnOnce(&mut T) -> U) -> U {
        self.instructions.carry_out(&mut self.value, work)
    }
}
