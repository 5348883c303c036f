//! Materials of MTL files.

use std::collections::BTreeSet;
use std::convert::Infallible;

use crate::files::obj::lines::{Line, for_each_line, text_of};

/// What Lobe uses of a material.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct MtlMaterial {
    pub(crate) name: String,
    pub(crate) diffuse: Option<[f32; 3]>,
    pub(crate) diffuse_texture: Option<String>,
    pub(crate) emissive: [f32; 3],
    pub(crate) is_transparent: bool,
    /// Keywords that change how the surface looks and are not used.
    unused: BTreeSet<&'static str>,
}

/// Keywords of mirrors, gloss, glow, glass and relief.
const UNUSED: [&str; 27] = [
    "Ks", "map_Ks", "map_Ns", "refl", "map_refl", "Pr", "map_Pr", "Pm", "map_Pm", "Ps", "map_Ps", "Pc", "Pcr", "aniso",
    "anisor", "map_Ke", "Tf", "Km", "bump", "map_bump", "map_Bump", "bump_map", "norm", "disp", "map_disp", "decal",
    "illum",
];

/// The largest model of illumination that is that of a matte surface, but for its highlights: the next ones mirror or
/// let light through.
const LARGEST_MATTE: f32 = 2.0;

/// Reads the materials of an MTL file, and a note for each line that is not understood or not used.
pub(crate) fn read_mtl(bytes: &[u8], name: &str) -> (Vec<MtlMaterial>, Vec<String>) {
    let (mut materials, mut notes) = (Vec::<MtlMaterial>::new(), Vec::new());
    let Ok(()) = for_each_line(&text_of(bytes), |line| {
        if line.keyword == "newmtl" {
            materials.push(MtlMaterial { name: line.rest.to_owned(), ..MtlMaterial::default() });
        } else if let Some(material) = materials.last_mut()
            && let Err(message) = material.set(&line)
        {
            notes.push(format!("{name}: line {}: {message}", line.number));
        }
        Ok::<(), Infallible>(())
    });
    let unused: BTreeSet<&str> = materials.iter().flat_map(|material| &material.unused).copied().collect();
    if !unused.is_empty() {
        let unused = unused.into_iter().collect::<Vec<_>>().join(", ");
        notes.push(format!("{name}: not used: {unused}; surfaces are matte, of the color Kd and map_Kd"));
    }
    (materials, notes)
}

impl MtlMaterial {
    fn set(&mut self, line: &Line<'_>) -> Result<(), String> {
        match line.keyword {
            "Kd" => self.diffuse = Some(color(line)?),
            "Ke" => self.emissive = color(line)?,
            "d" => self.is_transparent |= number(line)? < 1.0,
            "Tr" => self.is_transparent |= number(line)? > 0.0,
            "map_d" => self.is_transparent = true,
            "map_Kd" => {
                let file = file_of(line.rest);
                if file.is_empty() {
                    return Err("expected the name of a picture after map_Kd, found none".to_owned());
                }
                self.diffuse_texture = Some(file.replace('\\', "/"));
                if file.len() < line.rest.len() {
                    return Err("the options of map_Kd are not used".to_owned());
                }
            }
            keyword => self.unused.extend(UNUSED.iter().filter(|known| **known == keyword && says_something(line))),
        }
        Ok(())
    }
}

/// Whether a line that is not used asks for more than a matte surface: a factor of zero does not.
fn says_something(line: &Line<'_>) -> bool {
    let least = if line.keyword == "illum" { LARGEST_MATTE } else { 0.0 };
    let default = if line.keyword == "Tf" || line.keyword == "Pr" { 1.0 } else { 0.0 };
    match line.numbers::<f32>() {
        Some(numbers) => numbers.iter().any(|number| *number > least && *number != default),
        None => true,
    }
}

/// Three numbers, or one for all.
fn color(line: &Line<'_>) -> Result<[f32; 3], String> {
    match line.numbers::<f32>().as_deref() {
        Some(&[gray]) => Ok([gray; 3]),
        Some(&[r, g, b]) => Ok([r, g, b]),
        _ => Err(format!("expected three numbers after {}, found `{}`", line.keyword, line.rest)),
    }
}

/// The last number: `d` may have an option before it.
fn number(line: &Line<'_>) -> Result<f32, String> {
    let last = line.words().last().and_then(|word| word.parse().ok());
    last.ok_or_else(|| format!("expected a number after {}, found `{}`", line.keyword, line.rest))
}

/// The file name of a texture, which may have spaces in it, behind its options.
fn file_of(rest: &str) -> &str {
    let mut rest = rest;
    while rest.starts_with('-') {
        let (option, mut after) = rest.split_once(char::is_whitespace).unwrap_or((rest, ""));
        let (least, most) = match option {
            "-o" | "-s" | "-t" => (1, 3),
            "-mm" => (2, 2),
            "-blendu" | "-blendv" | "-bm" | "-boost" | "-cc" | "-clamp" | "-imfchan" | "-texres" | "-type" => (1, 1),
            _ => return rest,
        };
        for k in 0..most {
            let (word, next) = after.trim_start().split_once(char::is_whitespace).unwrap_or((after.trim_start(), ""));
            if k >= least && word.parse::<f32>().is_err() {
                break;
            }
            after = next;
        }
        rest = after.trim_start();
    }
    rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn materials_are_read_and_what_is_not_understood_is_named_by_its_line() {
        let text = "Kd 9 9 9\nnewmtl\nKd 0.5\nnewmtl a b\nKd 1 x 1\nKe 1 2 3\nmap_Kd -s 2 2 -clamp on my dir\\pic.png\n\
                    d -halo 0.5\nillum 2\nmap_Kd\n";
        let (materials, notes) = read_mtl(text.as_bytes(), "a.mtl");
        let gray = MtlMaterial { diffuse: Some([0.5; 3]), ..MtlMaterial::default() };
        let rest = MtlMaterial {
            name: "a b".into(),
            diffuse_texture: Some("my dir/pic.png".into()),
            emissive: [1.0, 2.0, 3.0],
            is_transparent: true,
            ..MtlMaterial::default()
        };
        assert_eq!(materials, [gray, rest], "materials");
        let expected = [
            "a.mtl: line 5: expected three numbers after Kd, found `1 x 1`",
            "a.mtl: line 7: the options of map_Kd are not used",
            "a.mtl: line 10: expected the name of a picture after map_Kd, found none",
        ];
        assert_eq!(notes, expected, "notes");
    }

    #[test]
    fn names_of_pictures_may_begin_with_a_number_or_a_dash() {
        for (rest, expected) in [
            ("1 2.png", "1 2.png"),
            ("-x y.png", "-x y.png"),
            ("-o 1 2 3 4.png", "4.png"),
            ("-o 1 a.png", "a.png"),
            ("-s", ""),
        ] {
            assert_eq!(file_of(rest), expected, "{rest}");
        }
    }
}
