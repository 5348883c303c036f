//! Bands 1 to 7 of one function in `f32`, each in one or two registers of AVX2.
//!
//! Bands 1 and 2 are those of `closed_bands`, to the bit. From band 4 on `m` is sorted as in [`WAVES`], cosines in one
//! register and sines in another, so that rotations about z are products place by place, and the four blocks of the
//! exchange of y and z sums over the places of a half. Band 3 is one register.
//
// With D = R_y(β) between the cosines or between the sines of band 3,
//
//   D_m'm = ρ^p (A + B cos²β) cos^e β        ρ = sin β        p = 1 where m + m' is odd, else 0        e = 0 or 1
//
// What `register_turns` leaves out, 1/ρ for odd m and for odd m', is with ρ^p 1/ρ² where both are odd, and 1 elsewhere:
// band 3 waits for no root. With one, order 4 took a tenth longer.

use std::arch::x86_64::{__m128, __m256};

use pulp::x86::V3;

use crate::basis::index::{band_range, coefficient_count};
use crate::once::Once;
use crate::rotation::closed_bands::SQRT_3;
use crate::rotation::register_turns::{LANES, LEAST_SQUARE, Matrix, Turns, WAVES, ZTurn};
use crate::rotation::yz_exchange::{SplitBand, YzExchange};

/// The fewest coefficients that are turned here.
const LEAST_COUNT: usize = coefficient_count(3);

/// The lowest band of two registers.
const FIRST_PAIR: usize = 4;

/// The highest of them.
const LAST_PAIR: usize = 7;

/// Cosines or sines of a band that are summed in the exchange.
const SUMMED: usize = 4;

type Numbers = [f32; LANES];
type Places = [i32; LANES];

/// Turns bands 0 to 7 of `src`, as far as it has them, into `dst`; whether there is code for them, from order 3 on
/// where the matrix determines its angles.
pub(crate) fn rotate_in_registers(v3: V3, matrix: &Matrix, src: &[f32], dst: &mut [f32]) -> bool {
    let square = matrix[0][2] * matrix[0][2] + matrix[1][2] * matrix[1][2];
    let needs_angles = src.len() > LEAST_COUNT;
    if src.len() < LEAST_COUNT || src.len() != dst.len() || needs_angles && square < LEAST_SQUARE {
        return false;
    }
    v3.vectorize(Turn { v3, matrix, square, tables: Tables::shared(), src, dst });
    true
}

/// A type, because closures are not compiled for the instructions.
struct Turn<'a> {
    v3: V3,
    matrix: &'a Matrix,
    square: f64,
    tables: &'a Tables,
    src: &'a [f32],
    dst: &'a mut [f32],
}

impl pulp::NullaryFnOnce for Turn<'_> {
    type Output = ();

    #[inline(always)]
    fn call(self) {
        let (v, matrix, square) = (self.v3, self.matrix, self.square);
        match self.src.len() {
            0..=9 => self.by(None),
            10..=16 => self.by(Some(Turns::new::<2>(v, matrix, square))),
            17..=36 => self.by(Some(Turns::new::<3>(v, matrix, square))),
            _ => self.by(Some(Turns::new::<4>(v, matrix, square))),
        }
    }
}

impl Turn<'_> {
    #[inline(always)]
    fn by(self, turns: Option<Turns>) {
        let Self { v3: v, matrix, tables, src, dst, .. } = self;
        if let Some(turns) = turns {
            third_band(v, &tables.tilt, &turns, matrix[2][2] as f32, src, dst);
            // The bits that say which places of a register are cosines: from m = 0 on.
            pair_of_band::<4, 0xf0, 0xf8>(v, tables, &turns, src, dst);
            pair_of_band::<5, 0xe0, 0xfc>(v, tables, &turns, src, dst);
            pair_of_band::<6, 0xc0, 0xfe>(v, tables, &turns, src, dst);
            pair_of_band::<7, 0x80, 0xff>(v, tables, &turns, src, dst);
        }
        first_bands(v, matrix, src, dst);
    }
}

#[inline(always)]
fn load(from: &[f32]) -> __m256 {
    let mut numbers = [0.0; LANES];
    numbers.copy_from_slice(&from[..LANES]);
    pulp::cast(numbers)
}

#[inline(always)]
fn numbers(register: __m256) -> Numbers {
    pulp::cast(register)
}

#[inline(always)]
fn picked(v: V3, register: __m256, places: Places) -> __m256 {
    v.avx2._mm256_permutevar8x32_ps(register, pulp::cast(places))
}

/// Bands 0, 1 and 2, as `closed_bands` has them: `i` in the places of a register.
#[inline(always)]
fn first_bands(v: V3, matrix: &Matrix, src: &[f32], dst: &mut [f32]) {
    let (Some(f), Some(out)) = (src.first_chunk::<LEAST_COUNT>(), dst.first_chunk_mut::<LEAST_COUNT>()) else {
        return;
    };
    let columns = single_columns(v, matrix);
    let all = |number: f32| v.sse._mm_set1_ps(number);
    let vector = numbers_of(dot(v, [all(-f[3]), all(-f[1]), all(f[2])], columns));
    out[..4].copy_from_slice(&[f[0], -vector[1], vector[2], -vector[0]]);
    let third = f[6] * (SQRT_3.recip() as f32);
    let (xy, xz, yz) = (all(f[4]), all(-f[7]), all(-f[5]));
    let rows = [
        dot(v, [all(f[8] - third), xy, xz], columns),
        dot(v, [xy, all(-f[8] - third), yz], columns),
        dot(v, [xz, yz, all(third + third)], columns),
    ];
    let crossed = dot(v, apart(v, rows), next(v, columns));
    let scales = pulp::cast([1.0, -1.0, (0.5 * SQRT_3) as f32, -1.0]);
    out[4..8].copy_from_slice(&numbers_of(v.sse._mm_mul_ps(crossed, scales)));
    let along = numbers_of(dot(v, rows, columns));
    out[8] = (along[0] - along[1]) * 0.5;
}

/// The columns of the matrix.
#[inline(always)]
fn single_columns(v: V3, matrix: &Matrix) -> [__m128; 3] {
    let m = matrix.as_flattened();
    let (first, second, last) = (four_singles(v, &m[0..4]), four_singles(v, &m[3..7]), four_singles(v, &m[5..9]));
    let low = v.sse._mm_unpacklo_ps(first, second);
    [
        v.sse._mm_shuffle_ps::<0b01_01_01_00>(low, last),
        v.sse._mm_shuffle_ps::<0b10_10_11_10>(low, last),
        v.sse._mm_shuffle_ps::<0b11_11_01_00>(v.sse._mm_unpackhi_ps(first, second), last),
    ]
}

#[inline(always)]
fn four_singles(v: V3, from: &[f64]) -> __m128 {
    let mut four = [0.0; 4];
    four.copy_from_slice(from);
    v.avx._mm256_cvtpd_ps(pulp::cast(four))
}

#[inline(always)]
fn numbers_of(register: __m128) -> [f32; 4] {
    pulp::cast(register)
}

/// Rounded as that of `closed_bands`.
#[inline(always)]
fn dot(v: V3, a: [__m128; 3], b: [__m128; 3]) -> __m128 {
    v.fma._mm_fmadd_ps(a[2], b[2], v.fma._mm_fmadd_ps(a[1], b[1], v.sse._mm_mul_ps(a[0], b[0])))
}

/// Places 0, 1, 2 and 0 of each.
#[inline(always)]
fn apart(v: V3, [a, b, c]: [__m128; 3]) -> [__m128; 3] {
    [
        v.sse._mm_shuffle_ps::<0b00_10_01_00>(a, a),
        v.sse._mm_shuffle_ps::<0b00_10_01_00>(b, b),
        v.sse._mm_shuffle_ps::<0b00_10_01_00>(c, c),
    ]
}

/// Places 1, 2, 2 and 2 of each.
#[inline(always)]
fn next(v: V3, [a, b, c]: [__m128; 3]) -> [__m128; 3] {
    [
        v.sse._mm_shuffle_ps::<0b10_10_10_01>(a, a),
        v.sse._mm_shuffle_ps::<0b10_10_10_01>(b, b),
        v.sse._mm_shuffle_ps::<0b10_10_10_01>(c, c),
    ]
}

/// Band 3 with `m = 0, 1, 2, 3` in the places of a half, cosines in the first.
#[inline(always)]
fn third_band(v: V3, tilt: &Tilt, turns: &Turns, cos_beta: f32, src: &[f32], dst: &mut [f32]) {
    let f = picked(v, load(&src[8..16]), [4, 5, 6, 7, 4, 3, 2, 1]);
    let f = turned_in_halves(v, turns.gamma, f);
    let cos = v.avx._mm256_set1_ps(cos_beta);
    let square = v.avx._mm256_mul_ps(cos, cos);
    let one = v.avx._mm256_set1_ps(1.0);
    let even = v.avx._mm256_blend_ps::<0b1010_0101>(one, cos);
    let odd = v.avx._mm256_blend_ps::<0b0101_1010>(one, cos);
    let odd = v.avx._mm256_mul_ps(odd, v.avx._mm256_blend_ps::<0b1010_1010>(one, turns.inverse_square));
    let (a, b) = (tilt.column(v, 0, square, even), tilt.column(v, 1, square, odd));
    let (c, d) = (tilt.column(v, 2, square, even), tilt.column(v, 3, square, odd));
    let evens = v.avx._mm256_mul_ps(a, v.avx._mm256_permute_ps::<0x00>(f));
    let odds = v.avx._mm256_mul_ps(b, v.avx._mm256_permute_ps::<0x55>(f));
    let evens = v.fma._mm256_fmadd_ps(c, v.avx._mm256_permute_ps::<0xaa>(f), evens);
    let odds = v.fma._mm256_fmadd_ps(d, v.avx._mm256_permute_ps::<0xff>(f), odds);
    let f = turned_in_halves(v, turns.short_alpha, v.avx._mm256_add_ps(evens, odds));
    dst[9..13].copy_from_slice(&numbers(picked(v, f, [7, 6, 5, 0, 0, 0, 0, 0]))[..4]);
    dst[12..16].copy_from_slice(&numbers(f)[..4]);
}

/// Turned about z, cosines and sines in the halves of one register.
#[inline(always)]
fn turned_in_halves(v: V3, turn: ZTurn, f: __m256) -> __m256 {
    const IN_ORDER: Places = [0, 4, 1, 5, 0, 4, 1, 5];
    let signs = pulp::cast([-0.0_f32, -0.0, -0.0, -0.0, 0.0, 0.0, 0.0, 0.0]);
    let (cos, sin) = (picked(v, turn.cos, IN_ORDER), v.avx._mm256_xor_ps(picked(v, turn.sin, IN_ORDER), signs));
    let exchanged = v.avx._mm256_permute2f128_ps::<0x01>(f, f);
    v.fma._mm256_fmadd_ps(cos, f, v.avx._mm256_mul_ps(sin, exchanged))
}

/// The cosines and the sines of a band, in the places of [`WAVES`].
#[derive(Clone, Copy)]
struct Pair {
    cos: __m256,
    sin: __m256,
}

impl Pair {
    #[inline(always)]
    fn turned(self, v: V3, turn: ZTurn) -> Self {
        Self {
            cos: v.fma._mm256_fnmadd_ps(turn.sin, self.sin, v.avx._mm256_mul_ps(turn.cos, self.cos)),
            sin: v.fma._mm256_fmadd_ps(turn.sin, self.cos, v.avx._mm256_mul_ps(turn.cos, self.sin)),
        }
    }

    #[inline(always)]
    fn scaled(self, v: V3, by: __m256) -> Self {
        Self { cos: v.avx._mm256_mul_ps(self.cos, by), sin: v.avx._mm256_mul_ps(self.sin, by) }
    }

    /// With y and z exchanged: in odd bands cosines of even `m` and sines of odd `m` become each other, in even ones
    /// sines of even and cosines of odd `m`; the others stay what they are.
    #[inline(always)]
    fn exchanged<const L: usize>(self, v: V3, exchange: &PairExchange) -> Self {
        let Self { cos, sin } = self;
        let [to_cos, to_sin] = if L.is_multiple_of(2) {
            [v.avx._mm256_permute2f128_ps::<0x20>(cos, sin), v.avx._mm256_permute2f128_ps::<0x31>(cos, sin)]
        } else {
            [v.avx._mm256_permute2f128_ps::<0x31>(sin, cos), v.avx._mm256_permute2f128_ps::<0x20>(sin, cos)]
        };
        Self { cos: product::<L>(v, &exchange.to_cos, to_cos), sin: product::<L>(v, &exchange.to_sin, to_sin) }
    }
}

/// A matrix of each half, by columns, times the numbers of that half: three of them below band 6.
#[inline(always)]
fn product<const L: usize>(v: V3, columns: &[Numbers; SUMMED], f: __m256) -> __m256 {
    let [a, b, c, d] = *columns;
    let sum = v.avx._mm256_mul_ps(pulp::cast(a), v.avx._mm256_permute_ps::<0x00>(f));
    let sum = v.fma._mm256_fmadd_ps(pulp::cast(b), v.avx._mm256_permute_ps::<0x55>(f), sum);
    let sum = v.fma._mm256_fmadd_ps(pulp::cast(c), v.avx._mm256_permute_ps::<0xaa>(f), sum);
    if L < 6 { sum } else { v.fma._mm256_fmadd_ps(pulp::cast(d), v.avx._mm256_permute_ps::<0xff>(f), sum) }
}

/// Turns band `L`, if there is one, by `Z(α) J Z(-β) J Z(γ)`. The bits of `FIRST` and `LAST` say which of the first and
/// of the last eight coefficients are cosines.
#[inline(always)]
fn pair_of_band<const L: usize, const FIRST: i32, const LAST: i32>(
    v: V3,
    tables: &Tables,
    turns: &Turns,
    src: &[f32],
    dst: &mut [f32],
) {
    let (Some(from), Some(to)) = (src.get(band_range(L)), dst.get_mut(band_range(L))) else { return };
    let (places, exchange) = (&tables.places[L - FIRST_PAIR], &tables.pairs[L - FIRST_PAIR]);
    let last = from.len() - LANES;
    let f = Pair {
        cos: picked(v, load(&from[last..]), places.cos_from_last),
        sin: picked(v, load(from), places.sin_from_first),
    };
    let f = f.turned(v, turns.gamma).scaled(v, turns.odd).exchanged::<L>(v, exchange);
    let f = f.turned(v, turns.beta).exchanged::<L>(v, exchange).turned(v, turns.alpha);
    let (sin, cos) = (picked(v, f.sin, places.first_from_sin), picked(v, f.cos, places.first_from_cos));
    to[..LANES].copy_from_slice(&numbers(v.avx._mm256_blend_ps::<FIRST>(sin, cos)));
    let (sin, cos) = (picked(v, f.sin, places.last_from_sin), picked(v, f.cos, places.last_from_cos));
    to[last..].copy_from_slice(&numbers(v.avx._mm256_blend_ps::<LAST>(sin, cos)));
}

/// What depends on no rotation.
struct Tables {
    tilt: Tilt,
    pairs: [PairExchange; LAST_PAIR - FIRST_PAIR + 1],
    places: [PairPlaces; LAST_PAIR - FIRST_PAIR + 1],
}

impl Tables {
    fn shared() -> &'static Self {
        static SHARED: Once<Tables> = Once::new();
        SHARED.get_or_init(|| {
            let exchange = YzExchange::new(LAST_PAIR + 1);
            Self {
                tilt: Tilt::new(&BandMatrix::new(&exchange, 3)),
                pairs: core::array::from_fn(|k| PairExchange::new(&BandMatrix::new(&exchange, FIRST_PAIR + k))),
                places: core::array::from_fn(|k| PairPlaces::new(FIRST_PAIR + k)),
            }
        })
    }
}

/// The exchange of y and z in one band.
struct BandMatrix {
    l: usize,
    columns: Vec<Vec<f64>>,
}

impl BandMatrix {
    fn new(exchange: &YzExchange, l: usize) -> Self {
        let places = SplitBand::<f64>::places(l + 1);
        let columns = (0..=2 * l).map(|column| {
            let (mut from, mut to) = (vec![0.0; places], vec![0.0; places]);
            let (mut from, mut to) = (SplitBand::new(l + 1, &mut from), SplitBand::new(l + 1, &mut to));
            let mut band = vec![0.0; 2 * l + 1];
            band[column] = 1.0;
            from.load(l, &band);
            exchange.band(l).apply(l, &from, &mut to);
            to.store(l, &mut band);
            band
        });
        Self { l, columns: columns.collect() }
    }

    /// The entry to a cosine or sine from another, each by `m` and whether it is a sine; 0 where there is none.
    fn entry(&self, (row, row_is_sin): (usize, bool), (column, column_is_sin): (usize, bool)) -> f64 {
        let exists = |m: usize, is_sin: bool| m <= self.l && (m > 0 || !is_sin);
        let at = |m: usize, is_sin: bool| if is_sin { self.l - m } else { self.l + m };
        if exists(row, row_is_sin) && exists(column, column_is_sin) {
            self.columns[at(column, column_is_sin)][at(row, row_is_sin)]
        } else {
            0.0
        }
    }
}

/// The exchange of y and z of a band, by columns.
struct PairExchange {
    to_cos: [Numbers; SUMMED],
    to_sin: [Numbers; SUMMED],
}

impl PairExchange {
    fn new(matrix: &BandMatrix) -> Self {
        let column = |k: usize, is_sin: bool| -> Numbers {
            core::array::from_fn(|place| {
                // From which half each half is summed: see `Pair::exchanged`.
                let is_even_half = place < LANES / 2;
                let (from_sin, from_odd) =
                    if matrix.l.is_multiple_of(2) { (!is_even_half, is_sin) } else { (is_even_half, !is_sin) };
                matrix.entry((WAVES[place], is_sin), (2 * k + usize::from(from_odd), from_sin)) as f32
            })
        };
        Self { to_cos: core::array::from_fn(|k| column(k, false)), to_sin: core::array::from_fn(|k| column(k, true)) }
    }
}

/// Where the numbers of registers lie in the first and in the last eight coefficients of a band, and these in those.
struct PairPlaces {
    cos_from_last: Places,
    sin_from_first: Places,
    first_from_cos: Places,
    first_from_sin: Places,
    last_from_cos: Places,
    last_from_sin: Places,
}

impl PairPlaces {
    fn new(l: usize) -> Self {
        // Places without a function have that of another, which has no part in what is summed.
        let wave = |place: usize, least: usize| if WAVES[place] <= l { WAVES[place].max(least) } else { least };
        let place_of = |m: usize| if m.is_multiple_of(2) { m / 2 } else { LANES / 2 + m / 2 } as i32;
        let skipped = LANES - 1 - l;
        let places = |of: &dyn Fn(usize) -> usize| core::array::from_fn(|i| place_of(of(i)));
        Self {
            cos_from_last: core::array::from_fn(|place| (skipped + wave(place, 0)) as i32),
            sin_from_first: core::array::from_fn(|place| (l - wave(place, 1)) as i32),
            first_from_cos: places(&|i| i.saturating_sub(l)),
            first_from_sin: places(&|i| l.saturating_sub(i)),
            last_from_cos: places(&|i| i.saturating_sub(skipped)),
            last_from_sin: places(&|i| skipped.saturating_sub(i)),
        }
    }
}

/// `A` and `B` of `D_m'm` in band 3, by columns, cosines in the first half.
struct Tilt {
    constant: [Numbers; 4],
    of_square: [Numbers; 4],
}

impl Tilt {
    /// From `D = J Z(-β) J` at two angles.
    fn new(exchange: &BandMatrix) -> Self {
        let mut tilt = Self { constant: [[0.0; LANES]; 4], of_square: [[0.0; LANES]; 4] };
        for column in 0..4 {
            for place in 0..LANES {
                let (row, is_sin) = (place % 4, place >= 4);
                let [a, b] = ANGLES.map(|beta| reduced(exchange, beta, [row, column], is_sin));
                let [x, y] = ANGLES.map(|beta| beta.cos().powi(2));
                let slope = (a - b) / (x - y);
                tilt.of_square[column][place] = slope as f32;
                tilt.constant[column][place] = (a - slope * x) as f32;
            }
        }
        tilt
    }

    /// Column `m` of `D`, its even or odd powers of `cos β` given.
    #[inline(always)]
    fn column(&self, v: V3, m: usize, square: __m256, powers: __m256) -> __m256 {
        let (slope, constant) = (pulp::cast(self.of_square[m]), pulp::cast(self.constant[m]));
        v.avx._mm256_mul_ps(powers, v.fma._mm256_fmadd_ps(slope, square, constant))
    }
}

/// Any two, whose cosines and sines are not small.
const ANGLES: [f64; 2] = [0.5, 1.2];

/// `D_m'm / (ρ^p cos^e β)` of band 3 between cosines or sines; 0 where there is no function.
fn reduced(exchange: &BandMatrix, beta: f64, [row, column]: [usize; 2], is_sin: bool) -> f64 {
    if is_sin && (row == 0 || column == 0) {
        return 0.0;
    }
    let at = |m: usize| if is_sin { 3 - m } else { 3 + m };
    let (f, to) = (&exchange.columns[at(column)], &exchange.columns[at(row)]);
    let waves = (1..=3).map(|m| {
        let (sin, cos) = (-(m as f64) * beta).sin_cos();
        let (minus, plus) = (f[3 - m], f[3 + m]);
        (minus * cos + plus * sin) * to[3 - m] + (plus * cos - minus * sin) * to[3 + m]
    });
    let entry = f[3] * to[3] + waves.sum::<f64>();
    let (p, e) = ((row + column) % 2, (row + column + usize::from(!is_sin)) % 2);
    entry / (beta.sin().powi(p as i32) * beta.cos().powi(e as i32))
}
