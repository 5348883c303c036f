//! Bounds, area and turn of a scene at its bake, by which objects that were moved afterwards are noticed.

use std::io;

use lobe_scene::Scene;
use serde_json::{Value, json};

use crate::transfer::transfer_rows::TransferRows;

/// The vertices whose transfer is compared with their normals at most.
const MOST_SAMPLES: usize = 4096;

/// How far bounds may move, relative to their diagonal. Positions of 12 bits move by a quarter of it.
const MOST_MOVED: f64 = 1e-3;

/// How far the area may change, relative to it: triangles that vanish where positions are rounded.
const MOST_AREA: f64 = 0.01;

/// How far the alignment may change: other samples have a mean that is off by a sixty-fourth of their spread.
const MOST_TURNED: f64 = 0.1;

/// What does not change where a program orders, merges or rounds vertices.
///
/// ```text
///   alignment = Σ n·v / Σ |v|,   v = (-T_3, -T_1, T_2) of all channels: where light comes from
/// ```
///
/// A ball that is turned about its center has the same bounds, and another alignment.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BakedShape {
    bounds: [[f64; 3]; 2],
    area: f64,
    /// Vertices by their number among all, and their normals.
    samples: Vec<(usize, [f32; 3])>,
}

impl BakedShape {
    pub(crate) fn of(scene: &Scene) -> Self {
        let mut bounds = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        let (mut area, mut samples, mut first) = (0.0, Vec::new(), 0);
        let step = scene.vertex_count().div_ceil(MOST_SAMPLES).max(1);
        for mesh in scene.meshes() {
            let at = |i: u32| mesh.positions()[i as usize].map(f64::from);
            for [a, b, c] in mesh.triangles().iter().map(|triangle| triangle.map(at)) {
                area += 0.5 * length(cross(difference(b, a), difference(c, a)));
                for corner in [a, b, c] {
                    bounds[0] = std::array::from_fn(|k| bounds[0][k].min(corner[k]));
                    bounds[1] = std::array::from_fn(|k| bounds[1][k].max(corner[k]));
                }
            }
            let normals = mesh.normals().iter().enumerate().map(|(i, normal)| (first + i, *normal));
            samples.extend(normals.filter(|(i, _)| i % step == 0));
            first += mesh.positions().len();
        }
        Self { bounds, area, samples }
    }

    /// The member `shape` of `extras.lobe`, with the alignment of the transfer.
    ///
    /// # Errors
    /// Those of reading rows.
    pub(crate) fn described(&self, transfer: &dyn TransferRows) -> io::Result<Value> {
        Ok(json!({"bounds": self.bounds, "area": self.area, "alignment": self.alignment(transfer)?}))
    }

    /// What differs from the description of a file, in words; none of a file that has none.
    ///
    /// # Errors
    /// Those of reading rows.
    pub(crate) fn differs(&self, said: &Value, transfer: &dyn TransferRows) -> io::Result<Option<&'static str>> {
        let number = |at: &str| said.pointer(at).and_then(Value::as_f64);
        let diagonal = length(difference(self.bounds[1], self.bounds[0]));
        let is_moved = (0..6).any(|i| {
            let [end, k] = [i / 3, i % 3];
            number(&format!("/bounds/{end}/{k}"))
                .is_some_and(|was| (self.bounds[end][k] - was).abs() > MOST_MOVED * diagonal)
        });
        if is_moved {
            return Ok(Some("its bounds are others"));
        }
        if number("/area").is_some_and(|was| (self.area - was).abs() > MOST_AREA * was) {
            return Ok(Some("its area is another"));
        }
        let is_turned = match number("/alignment").zip(self.alignment(transfer)?) {
            Some((was, is)) => (was - is).abs() > MOST_TURNED,
            None => false,
        };
        Ok(is_turned.then_some("its transfer does not go with its normals"))
    }

    /// None where no vertex has a linear band.
    fn alignment(&self, transfer: &dyn TransferRows) -> io::Result<Option<f64>> {
        let bands = transfer.order() * transfer.order();
        if transfer.order() < 2 {
            return Ok(None);
        }
        let mut row = vec![0.0; transfer.row_len()];
        let [mut along, mut all] = [0.0; 2];
        for (vertex, normal) in self.samples.iter().filter(|(vertex, _)| *vertex < transfer.receivers()) {
            transfer.read_rows(*vertex, &mut row)?;
            let sum = |i: usize| row.chunks_exact(bands).map(|channel| f64::from(channel[i])).sum::<f64>();
            let v = [-sum(3), -sum(1), sum(2)];
            along += v.iter().zip(normal).map(|(v, n)| v * f64::from(*n)).sum::<f64>();
            all += length(v);
        }
        Ok((all > 0.0).then(|| along / all))
    }
}

fn difference(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|k| a[k] - b[k])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn length(v: [f64; 3]) -> f64 {
    v[0].hypot(v[1]).hypot(v[2])
}
