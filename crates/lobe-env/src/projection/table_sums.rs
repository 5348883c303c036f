//! Sums of texels times tables, the inner loops of all projections and of reconstruction.

use lobe_sh::Rgb;
use lobe_sh::simd::{MOST_PARTS, sum_of_parts, sum_parts};
use pulp::Simd;

/// Red, green and blue.
pub(crate) const CHANNELS: usize = 3;

/// Arithmetic on tables and on planes, each a channel of a row, all of one length, in double precision.
///
/// Types and loops instead of closures, also those of arrays, because closures need not be compiled for the instructions of the
/// machine.
pub(crate) trait TableSums: Copy {
    /// `Σ_k tables_t(k) planes_c(k)` for each table and each plane.
    fn sums<const TABLES: usize, const PLANES: usize>(
        self,
        tables: [&[f64]; TABLES],
        planes: [&[f64]; PLANES],
    ) -> [[f64; PLANES]; TABLES];

    /// `to_c(k) = Σ_t tables_t(k) scales_ct`, added to what is there if `adds`, of the first numbers of each line.
    fn set_scaled<const TABLES: usize, const LINES: usize, const LONGEST: usize>(
        self,
        to: &mut [[f64; LONGEST]; LINES],
        tables: [&[f64]; TABLES],
        scales: [[f64; TABLES]; LINES],
        adds: bool,
    );

    /// `to(k) += Σ_t tables_t(k) scales_t`.
    fn add_scaled<const TABLES: usize>(self, to: &mut [f64], tables: [&[f64]; TABLES], scales: [f64; TABLES]);
}

/// The channels of colors.
#[inline(always)]
pub(crate) fn widen(colors: &[Rgb<f32>], planes: &mut [Vec<f64>; CHANNELS]) {
    let count = colors.len();
    let [r, g, b] = planes;
    r.resize(count, 0.0);
    g.resize(count, 0.0);
    b.resize(count, 0.0);
    let (r, g, b) = (&mut r[..count], &mut g[..count], &mut b[..count]);
    for k in 0..count {
        r[k] = f64::from(colors[k].r);
        g[k] = f64::from(colors[k].g);
        b[k] = f64::from(colors[k].b);
    }
}

/// In plain code.
#[derive(Clone, Copy)]
pub(crate) struct PlainSums;

impl TableSums for PlainSums {
    #[inline(always)]
    fn sums<const TABLES: usize, const PLANES: usize>(
        self,
        tables: [&[f64]; TABLES],
        planes: [&[f64]; PLANES],
    ) -> [[f64; PLANES]; TABLES] {
        let mut sums = [[0.0; PLANES]; TABLES];
        for t in 0..TABLES {
            for c in 0..PLANES {
                sums[t][c] = sum_of_products(tables[t], planes[c]);
            }
        }
        sums
    }

    #[inline(always)]
    fn set_scaled<const TABLES: usize, const LINES: usize, const LONGEST: usize>(
        self,
        to: &mut [[f64; LONGEST]; LINES],
        tables: [&[f64]; TABLES],
        scales: [[f64; TABLES]; LINES],
        adds: bool,
    ) {
        for (to, scales) in to.iter_mut().zip(scales) {
            let to = &mut to[..tables[0].len()];
            if !adds {
                to.fill(0.0);
            }
            self.add_scaled(to, tables, scales);
        }
    }

    #[inline(always)]
    fn add_scaled<const TABLES: usize>(self, to: &mut [f64], tables: [&[f64]; TABLES], scales: [f64; TABLES]) {
        for (table, scale) in tables.into_iter().zip(scales) {
            to.iter_mut().zip(table).for_each(|(to, from)| *to += from * scale);
        }
    }
}

/// By the registers of the machine.
#[derive(Clone, Copy)]
pub(crate) struct WideSums<S: Simd>(pub(crate) S);

impl<S: Simd> TableSums for WideSums<S> {
    #[inline(always)]
    fn sums<const TABLES: usize, const PLANES: usize>(
        self,
        tables: [&[f64]; TABLES],
        planes: [&[f64]; PLANES],
    ) -> [[f64; PLANES]; TABLES] {
        let simd = self.0;
        let mut wide = [[[simd.splat_f64s(0.0); MOST_PARTS]; PLANES]; TABLES];
        for part in 0..sum_parts::<S>() {
            let sums = part_of_sums(simd, part, tables, planes);
            for t in 0..TABLES {
                for c in 0..PLANES {
                    wide[t][c][part] = sums[t][c];
                }
            }
        }
        let mut sums = [[0.0; PLANES]; TABLES];
        for t in 0..TABLES {
            for c in 0..PLANES {
                sums[t][c] = sum_of_parts(simd, wide[t][c]);
            }
        }
        sums
    }

    #[inline(always)]
    fn set_scaled<const TABLES: usize, const LINES: usize, const LONGEST: usize>(
        self,
        to: &mut [[f64; LONGEST]; LINES],
        tables: [&[f64]; TABLES],
        scales: [[f64; TABLES]; LINES],
        adds: bool,
    ) {
        let simd = self.0;
        let count = tables[0].len();
        let (tables, rests) = registers::<S, TABLES>(tables);
        let mut wide = [[simd.splat_f64s(0.0); TABLES]; LINES];
        for c in 0..LINES {
            for t in 0..TABLES {
                wide[c][t] = simd.splat_f64s(scales[c][t]);
            }
        }
        let mut of_tables = [simd.splat_f64s(0.0); TABLES];
        for k in 0..tables[0].len() {
            for t in 0..TABLES {
                of_tables[t] = tables[t][k];
            }
            for c in 0..LINES {
                let place = &mut S::as_mut_simd_f64s(&mut to[c]).0[k];
                let mut sum = if adds { *place } else { simd.splat_f64s(0.0) };
                for t in 0..TABLES {
                    sum = simd.mul_add_e_f64s(of_tables[t], wide[c][t], sum);
                }
                *place = sum;
            }
        }
        // Fused as well: registers of another width have another rest.
        for t in 0..TABLES {
            of_tables[t] = simd.partial_load_f64s(rests[t]);
        }
        for c in 0..LINES {
            let place = &mut to[c][count - rests[0].len()..count];
            let mut sum = if adds { simd.partial_load_f64s(place) } else { simd.splat_f64s(0.0) };
            for t in 0..TABLES {
                sum = simd.mul_add_e_f64s(of_tables[t], wide[c][t], sum);
            }
            simd.partial_store_f64s(place, sum);
        }
    }

    #[inline(always)]
    fn add_scaled<const TABLES: usize>(self, to: &mut [f64], tables: [&[f64]; TABLES], scales: [f64; TABLES]) {
        let simd = self.0;
        let (to, to_rest) = S::as_mut_simd_f64s(to);
        let (tables, rests) = registers::<S, TABLES>(tables);
        let mut wide = [simd.splat_f64s(0.0); TABLES];
        for t in 0..TABLES {
            wide[t] = simd.splat_f64s(scales[t]);
        }
        for (k, to) in to.iter_mut().enumerate() {
            for t in 0..TABLES {
                *to = simd.mul_add_e_f64s(tables[t][k], wide[t], *to);
            }
        }
        // Fused as well: registers of another width have another rest.
        let mut rest = simd.partial_load_f64s(to_rest);
        for t in 0..TABLES {
            rest = simd.mul_add_e_f64s(simd.partial_load_f64s(rests[t]), wide[t], rest);
        }
        simd.partial_store_f64s(to_rest, rest);
    }
}

/// The products in every [`sum_parts`]-th register from the one of `part` on, the last of which is filled up with zeros.
#[inline(always)]
fn part_of_sums<S: Simd, const TABLES: usize, const PLANES: usize>(
    simd: S,
    part: usize,
    tables: [&[f64]; TABLES],
    planes: [&[f64]; PLANES],
) -> [[S::f64s; PLANES]; TABLES] {
    let mut sums = [[simd.splat_f64s(0.0); PLANES]; TABLES];
    let (tables, table_rests) = registers::<S, TABLES>(tables);
    let (planes, plane_rests) = registers::<S, PLANES>(planes);
    let (mut of_tables, mut of_planes) = ([simd.splat_f64s(0.0); TABLES], [simd.splat_f64s(0.0); PLANES]);
    let (count, parts) = (planes[0].len(), sum_parts::<S>());
    for k in (part..count).step_by(parts) {
        for t in 0..TABLES {
            of_tables[t] = tables[t][k];
        }
        for c in 0..PLANES {
            of_planes[c] = planes[c][k];
        }
        add_products(simd, &mut sums, of_tables, of_planes);
    }
    if count % parts == part && !plane_rests[0].is_empty() {
        for t in 0..TABLES {
            of_tables[t] = simd.partial_load_f64s(table_rests[t]);
        }
        for c in 0..PLANES {
            of_planes[c] = simd.partial_load_f64s(plane_rests[c]);
        }
        add_products(simd, &mut sums, of_tables, of_planes);
    }
    sums
}

/// Slices of one length as registers of the same number, and what is left of each.
#[inline(always)]
fn registers<S: Simd, const N: usize>(slices: [&[f64]; N]) -> ([&[S::f64s]; N], [&[f64]; N]) {
    let (mut whole, mut rests): ([&[S::f64s]; N], [&[f64]; N]) = ([&[]; N], [&[]; N]);
    for n in 0..N {
        (whole[n], rests[n]) = S::as_simd_f64s(&slices[n][..slices[0].len()]);
    }
    (whole, rests)
}

#[inline(always)]
fn add_products<S: Simd, const TABLES: usize, const PLANES: usize>(
    simd: S,
    sums: &mut [[S::f64s; PLANES]; TABLES],
    tables: [S::f64s; TABLES],
    planes: [S::f64s; PLANES],
) {
    for t in 0..TABLES {
        for c in 0..PLANES {
            sums[t][c] = simd.mul_add_e_f64s(tables[t], planes[c], sums[t][c]);
        }
    }
}

/// Sums kept side by side: four 128-bit registers of `f64`, whose additions hide each other's latency.
const LANES: usize = 8;

/// The sum of the products of two slices of one length.
///
/// One table and one plane at a time: with several the compiler mixes lanes of different sums in one register.
#[inline(always)]
fn sum_of_products(a: &[f64], b: &[f64]) -> f64 {
    let ((a, rest_a), (b, rest_b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
    let mut sums = [0.0; LANES];
    for (a, b) in a.iter().zip(b) {
        for lane in 0..LANES {
            sums[lane] += a[lane] * b[lane];
        }
    }
    sums.iter().sum::<f64>() + rest_a.iter().zip(rest_b).map(|(a, b)| a * b).sum::<f64>()
}
