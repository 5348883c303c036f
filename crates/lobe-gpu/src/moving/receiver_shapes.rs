//! Receivers for shaders.

use std::ops::Range;

use lobe_shadow::ShadowReceivers;

/// Position, normal and albedo of a receiver, each with a fourth number.
pub(crate) type ReceiverShape = [f32; 12];

/// Some of the receivers.
pub(crate) fn receiver_shapes(receivers: &ShadowReceivers<'_>, of: Range<usize>) -> Vec<ReceiverShape> {
    shapes(receivers, of, |k| receivers.albedo(k))
}

/// The same, all white.
pub(crate) fn white_receiver_shapes(receivers: &ShadowReceivers<'_>, of: Range<usize>) -> Vec<ReceiverShape> {
    shapes(receivers, of, |_| [1.0; 3])
}

fn shapes(receivers: &ShadowReceivers<'_>, of: Range<usize>, albedo: impl Fn(usize) -> [f32; 3]) -> Vec<ReceiverShape> {
    let some = of.clone().zip(&receivers.positions()[of.clone()]).zip(&receivers.normals()[of]);
    some.map(|((k, p), n)| {
        let [r, g, b] = albedo(k);
        [p[0], p[1], p[2], 1.0, n[0], n[1], n[2], 0.0, r, g, b, 0.0]
    })
    .collect()
}
