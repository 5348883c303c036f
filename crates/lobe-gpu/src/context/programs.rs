//! Programs that a device has compiled.

use std::collections::HashMap;
use std::sync::{Arc, Mutex};

use crate::context::locked;
use crate::error::GpuError;

/// A compiled program and the layout of what it binds.
#[derive(Clone, Debug)]
pub(crate) struct Program<P> {
    pub(crate) pipeline: P,
    pub(crate) layout: wgpu::BindGroupLayout,
}

/// Programs by all that they were compiled from, such as their source: compilers of shaders take longer than anything else here.
#[derive(Debug)]
pub(crate) struct Programs<P>(Arc<Mutex<HashMap<String, Program<P>>>>);

// Derived, these would ask it of `P`.
impl<P> Clone for Programs<P> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<P> Default for Programs<P> {
    fn default() -> Self {
        Self(Arc::default())
    }
}

impl<P: Clone> Programs<P> {
    /// The program that was made with this key before, or now.
    pub(crate) fn get(
        &self,
        key: String,
        make: impl FnOnce() -> Result<Program<P>, GpuError>,
    ) -> Result<Program<P>, GpuError> {
        if let Some(program) = locked(&self.0).get(&key) {
            return Ok(program.clone());
        }
        let program = make()?;
        locked(&self.0).insert(key, program.clone());
        Ok(program)
    }
}
