// The data of every dispatch: the struct Span of src/backend/gpu/layout.rs. A test checks that both are equal.

override WORKGROUP_SIZE: u32;

// The part of a slice that one dispatch carries out.
struct Span {
    first_instance: u32,
    instances: u32,
    // Index of the first period within its stage.
    first: u32,
    periods: u32,
    // Periods since the start of the run.
    elapsed: u32,
    // 1 while stroboscopic states are kept, and everything is summed up where tangent vectors are carried; else 0.
    watched: u32,
}
