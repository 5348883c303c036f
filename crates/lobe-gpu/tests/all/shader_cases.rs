//! Cases of the functions for shaders: rows of arguments, with the results of the library.

use lobe_env::octahedral;
use lobe_prt::{Channels, CompressedTable, CompressedTransfer, TableWeights, Transfer};
use lobe_sh::encoding::{
    Ahd, AmbientCube, HBasis4, HBasis6, Hl2, Hl2Weights, IrradianceMatrix, IrradiancePolynomial, NonLinearL1,
    PackedIrradiance, PackedIrradiance5, Zh3, Zh3Axis,
};
use lobe_sh::filter::scale_bands_in_place;
use lobe_sh::{Coefficient as _, Dir, Expansion as _, Rgb, Rotation, Sh, ShVec, Window, Zonal, eval_basis};
use lobe_testkit::{Random, directions};

/// What a function takes, and what it should return.
pub(crate) struct Row {
    pub(crate) arguments: Vec<f32>,
    pub(crate) expected: Vec<f64>,
}

type Color = Rgb<f64>;

/// Random numbers in single precision, and the arguments of a row.
struct Maker {
    random: Random,
    arguments: Vec<f32>,
}

impl Maker {
    fn number(&mut self) -> f64 {
        let x = self.random.signed() as f32;
        self.arguments.push(x);
        f64::from(x)
    }

    fn numbers(&mut self, count: usize) -> Vec<f64> {
        (0..count).map(|_| self.number()).collect()
    }

    fn color(&mut self) -> Color {
        Rgb::new(self.number(), self.number(), self.number())
    }

    fn colors(&mut self, count: usize) -> Vec<Color> {
        (0..count).map(|_| self.color()).collect()
    }

    /// An expansion of so many coefficients.
    fn expansion(&mut self, count: usize) -> ShVec<Color> {
        ShVec::from_vec(self.colors(count)).unwrap()
    }

    /// Bands 0 and 1; one in eight has no band 1, and one in eight is nothing at all.
    fn linear(&mut self, case: usize) -> Sh<4, Color> {
        let first = self.arguments.len();
        let mut e = self.colors(4);
        // Most of the light comes from somewhere, all of it is rarely negative.
        let left = [4, 4, 4, 4, 4, 4, 1, 0][case % 8];
        for i in 0..4 {
            if i >= left {
                e[i] = Rgb::ZERO;
                self.arguments[first + 3 * i..first + 3 * i + 3].fill(0.0);
            } else if i == 0 && !case.is_multiple_of(3) {
                e[0] = Rgb::new(e[0].r.abs(), e[0].g.abs(), e[0].b.abs());
                self.arguments[first..first + 3].iter_mut().for_each(|x| *x = x.abs());
            }
        }
        Sh::from_slice(&e)
    }

    fn push(&mut self, numbers: impl IntoIterator<Item = f64>) {
        self.arguments.extend(numbers.into_iter().map(|x| x as f32));
    }

    /// A direction as an argument, and as single precision leaves it.
    fn direction(&mut self, s: [f64; 3]) -> Dir {
        self.push(s);
        Dir::new(s.map(|x| f64::from(x as f32))).unwrap()
    }
}

/// Rows for a function: every direction of the test kit, poles and seam among them, with numbers of its own.
pub(crate) fn rows(name: &str) -> Vec<Row> {
    let mut random =
        Random::new(name.bytes().fold(7, |sum: u64, byte| sum.wrapping_mul(31).wrapping_add(u64::from(byte))));
    let mut row = |(case, s): (usize, [f64; 3])| {
        let mut maker = Maker { random: Random::new(random.next_u64()), arguments: Vec::new() };
        let expected = expected(name, &mut maker, case, s);
        Row { arguments: maker.arguments, expected }
    };
    directions().into_iter().enumerate().map(&mut row).collect()
}

fn expected(name: &str, m: &mut Maker, case: usize, s: [f64; 3]) -> Vec<f64> {
    if name == "order_3_rotated" {
        return rotated(m);
    }
    match name.strip_prefix("order_").and_then(|rest| rest.split_once('_')) {
        Some((order, what)) => of_order(what, order.parse().unwrap(), m, s),
        None if name.contains("window") => vec![window(name, m, case)],
        None if name.starts_with("octahedral") => octahedral_point(name, m, s),
        None if name.starts_with("zh3_hallucinated") => hallucinated(name, m, case),
        None => flat([irradiance(name, m, case, s)]),
    }
}

fn flat(colors: impl IntoIterator<Item = Color>) -> Vec<f64> {
    colors.into_iter().flat_map(|c| [c.r, c.g, c.b]).collect()
}

fn of_order(what: &str, order: usize, m: &mut Maker, s: [f64; 3]) -> Vec<f64> {
    let count = order * order;
    match what {
        "basis" => eval_basis(m.direction(s), order),
        "eval" => {
            let f = m.expansion(count);
            flat([f.eval(m.direction(s))])
        }
        "irradiance" => {
            let e = m.expansion(count).convolved(&Zonal::clamped_cosine(order));
            flat([e.eval(m.direction(s))])
        }
        "scaled_bands" => {
            let mut f = m.colors(count);
            scale_bands_in_place(&mut f, &m.numbers(order));
            flat(f)
        }
        "exit_radiance" => exit_radiance(Channels::Gray, order, m),
        "exit_radiance_rgb" => exit_radiance(Channels::Rgb, order, m),
        other => panic!("no case for {other}"),
    }
}

/// One receiver; shaders have the channels of a coefficient together, the library has coefficients of a channel.
fn exit_radiance(channels: Channels, order: usize, m: &mut Maker) -> Vec<f64> {
    let (count, channel_count) = (order * order, channels.count());
    let given = m.numbers(count * channel_count);
    let own: Vec<f32> = (0..channel_count)
        .flat_map(|c| (0..count).map(move |i| (i, c)))
        .map(|(i, c)| given[i * channel_count + c] as f32)
        .collect();
    let transfer = Transfer::new(order, channels, own).unwrap();
    of_single(&transfer.exit_radiance(&m.colors(count)))
}

fn of_single(colors: &[Rgb<f32>]) -> Vec<f64> {
    colors.iter().flat_map(|c| [c.r, c.g, c.b]).map(f64::from).collect()
}

fn rotated(m: &mut Maker) -> Vec<f64> {
    let mut f = m.colors(9);
    let rotation = Rotation::from_quaternion(m.random.quaternion()).unwrap();
    for axis in [Dir::X, Dir::Y, Dir::Z] {
        m.push(rotation.rotate_dir(axis).to_array());
    }
    rotation.apply_in_place(&mut f);
    flat(f)
}

fn window(name: &str, m: &mut Maker, case: usize) -> f64 {
    let l = case % 8;
    let width = f64::from((1.0 + 8.0 * m.random.unit()) as f32);
    let window = match name {
        "hanning_window" => Window::Hanning { width },
        "lanczos_window" => Window::Lanczos { width, power: [1.0, 4.0][case % 2] },
        "gauss_window" => Window::Gauss { sigma: 0.125 * width },
        "squared_laplacian_window" => Window::SquaredLaplacian { lambda: 0.01 * width },
        other => panic!("no case for {other}"),
    };
    m.push([l as f64]);
    match window {
        Window::Hanning { width } => m.push([width]),
        Window::Lanczos { width, power } => m.push([width, power]),
        Window::Gauss { sigma } => m.push([sigma]),
        Window::SquaredLaplacian { lambda } => m.push([lambda]),
        other => panic!("no case for {other}"),
    }
    window.factor(l)
}

fn octahedral_point(name: &str, m: &mut Maker, s: [f64; 3]) -> Vec<f64> {
    match name {
        "octahedral_uv_from_dir" => {
            let (u, v) = octahedral::uv_from_dir(m.direction(s));
            vec![u, v]
        }
        "octahedral_dir_from_uv" => {
            let (u, v) = octahedral::uv_from_dir(Dir::new(s).unwrap());
            let (u, v) = (f64::from(u as f32), f64::from(v as f32));
            m.push([u, v]);
            octahedral::dir_from_uv(u, v).to_array().to_vec()
        }
        other => panic!("no case for {other}"),
    }
}

fn hallucinated(name: &str, m: &mut Maker, case: usize) -> Vec<f64> {
    let axis = if name.ends_with("per_channel") { Zh3Axis::PerChannel } else { Zh3Axis::Luminance };
    flat([Zh3::hallucinated(&m.linear(case), axis).zonal])
}

/// The forms that one color comes of.
fn irradiance(name: &str, m: &mut Maker, case: usize, s: [f64; 3]) -> Color {
    match name {
        "packed_irradiance_eval" | "packed_irradiance_5_eval" | "irradiance_matrix_eval" => packed(name, m, s),
        "irradiance_polynomial_eval" => {
            let l = m.colors(9).try_into().unwrap();
            IrradiancePolynomial { l }.eval(m.direction(s))
        }
        "non_linear_l1_eval" => NonLinearL1 { linear: m.linear(case) }.eval(m.direction(s)),
        "zh3_eval" | "zh3_per_channel_eval" => {
            let axis = if name == "zh3_eval" { Zh3Axis::Luminance } else { Zh3Axis::PerChannel };
            Zh3 { linear: m.linear(case), zonal: m.color(), axis }.eval(m.direction(s))
        }
        "ambient_cube_eval" => AmbientCube { faces: m.colors(6).try_into().unwrap() }.eval(m.direction(s)),
        "ahd_eval" => {
            let (ambient, highlight, towards) = (m.color(), m.color(), m.random.direction());
            Ahd { ambient, highlight, direction: m.direction(towards) }.eval(m.direction(s))
        }
        "clustered_exit_radiance" => clustered(m),
        _ => hemisphere(name, m, s),
    }
}

fn packed(name: &str, m: &mut Maker, s: [f64; 3]) -> Color {
    let mut values = Maker { random: Random::new(m.random.next_u64()), arguments: Vec::new() };
    let e = values.expansion(25);
    match name {
        "packed_irradiance_eval" => {
            let packed = PackedIrradiance::from_irradiance_sh(&e);
            m.arguments.extend(packed.to_vectors().into_iter().flatten());
            packed.eval(m.direction(s))
        }
        "packed_irradiance_5_eval" => {
            let packed = PackedIrradiance5::from_irradiance_sh(&e);
            m.arguments.extend(packed.to_vectors().into_iter().flatten());
            packed.eval(m.direction(s))
        }
        _ => {
            let matrix = IrradianceMatrix::from_irradiance_sh(&e);
            m.push(matrix.m.into_iter().flatten().flatten());
            matrix.eval(m.direction(s))
        }
    }
}

fn hemisphere(name: &str, m: &mut Maker, s: [f64; 3]) -> Color {
    let frame = Rotation::IDENTITY;
    let above = [s[0], s[1], s[2].abs()];
    match name {
        "h_basis_4_eval" => HBasis4 { coefficients: m.colors(4).try_into().unwrap(), frame }.eval(m.direction(above)),
        "h_basis_6_eval" => HBasis6 { coefficients: m.colors(6).try_into().unwrap(), frame }.eval(m.direction(above)),
        "hl2_eval" | "hl2_linear_eval" => {
            let weights = if name == "hl2_eval" { Hl2Weights::Squared } else { Hl2Weights::Linear };
            Hl2 { colors: m.colors(3).try_into().unwrap(), weights, frame }.eval(m.direction(above))
        }
        other => panic!("no case for {other}"),
    }
}

/// One receiver in one cluster of four components.
fn clustered(m: &mut Maker) -> Color {
    let mut values = Maker { random: Random::new(m.random.next_u64()), arguments: Vec::new() };
    let bases: Vec<f32> = values.numbers(5 * 9).into_iter().map(|x| x as f32).collect();
    let (weights, light) = (values.numbers(4), values.colors(9));
    let product = |k: usize| -> Color {
        let terms = bases[9 * k..9 * k + 9].iter().zip(&light);
        terms.fold(Rgb::ZERO, |sum, (b, l)| sum + l.scale(f64::from(*b)))
    };
    m.push(flat([product(0)]));
    m.push(weights.iter().copied());
    m.push(flat((1..5).map(product)));
    let weights = TableWeights::F32(weights.iter().map(|w| *w as f32).collect());
    let table = CompressedTable::new(9, 4, vec![0], weights, bases).unwrap();
    let found = CompressedTransfer::from_table(3, Channels::Gray, table).unwrap().exit_radiance(&light)[0];
    Rgb::new(f64::from(found.r), f64::from(found.g), f64::from(found.b))
}
