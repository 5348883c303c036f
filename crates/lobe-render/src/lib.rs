//! Pictures on the CPU.
