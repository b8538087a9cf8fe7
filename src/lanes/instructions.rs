//! Instruction sets as proofs, and values in their lanes that nothing gets at without one.
//!
//! Owns the contract between lanes and those who carry work out with them; detects and computes nothing.

/// A set of vector instructions that the machine has. A value is the proof of it: only detection makes one.
pub(crate) trait Instructions: Copy + Send + Sync + 'static {
    /// Carries work on `value` out in a function that is compiled for these instructions. So are the work itself and what it
    /// calls where they are `#[inline(always)]`, as all must be that takes long.
    fn carry_out<T, U>(self, value: T, work: impl FnOnce(T) -> U) -> U;
}

/// What every machine of the target has.
#[derive(Clone, Copy)]
pub(crate) struct Portable;

impl Instructions for Portable {
    #[inline(always)]
    fn carry_out<T, U>(self, value: T, work: impl FnOnce(T) -> U) -> U {
        work(value)
    }
}

/// A value in lanes of the instructions `I`: it is made and used only in work that these carry out.
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
