//! The basis on the device: module `basis`, written by `cargo xtask tables` from the constants of [`lobe_sh::basis::Basis`].

use crate::error::GpuError;

/// The highest order that shaders evaluate, that of [`lobe_prt::Transfer`].
pub(crate) const MAX_SHADER_ORDER: usize = lobe_prt::Transfer::MAX_ORDER;

/// Refuses an order without code.
pub(crate) fn check_order(order: usize) -> Result<(), GpuError> {
    if (1..=MAX_SHADER_ORDER).contains(&order) {
        return Ok(());
    }
    Err(GpuError::Options(format!("expected an order of 1 to {MAX_SHADER_ORDER}, found {order}")))
}
