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
    unused: BTreeSet<String>,
}

/// Keywords that say nothing of a matte surface. The width of highlights and how glass refracts count only beside
/// others, which are named.
const SILENT: [&str; 3] = ["ns", "ni", "sharpness"];

/// The most keywords that a note names.
const MOST_NAMED: usize = 32;

/// Reads the materials of an MTL file, and a note for each line that is not understood or not used.
pub(crate) fn read_mtl(bytes: &[u8], name: &str) -> (Vec<MtlMaterial>, Vec<String>) {
    let (mut materials, mut notes) = (Vec::<MtlMaterial>::new(), Vec::new());
    let Ok(()) = for_each_line(&text_of(bytes), |line| {
        if line.keyword.eq_ignore_ascii_case("newmtl") {
            materials.push(MtlMaterial { name: line.rest.to_owned(), ..MtlMaterial::default() });
        } else if let Some(material) = materials.last_mut()
            && let Err(message) = material.set(&line)
        {
            notes.push(format!("{name}: line {}: {message}", line.number));
        }
        Ok::<(), Infallible>(())
    });
    let unused: BTreeSet<&str> = materials.iter().flat_map(|material| &material.unused).map(String::as_str).collect();
    if !unused.is_empty() {
        let more =
            if unused.len() > MOST_NAMED { format!(" and {} more", unused.len() - MOST_NAMED) } else { String::new() };
        let unused = unused.into_iter().take(MOST_NAMED).collect::<Vec<_>>().join(", ") + &more;
        notes.push(format!("{name}: not used: {unused}; surfaces are matte, of the color Kd and map_Kd"));
    }
    (materials, notes)
}

impl MtlMaterial {
    /// Takes what a line says. Programs write keywords in capital and in small letters.
    fn set(&mut self, line: &Line<'_>) -> Result<(), String> {
        match &*line.keyword.to_ascii_lowercase() {
            "kd" => self.diffuse = Some(color(line)?),
            "ke" => self.emissive = color(line)?,
            "d" => self.is_transparent |= number(line)? < 1.0,
            "tr" => self.is_transparent |= number(line)? > 0.0,
            "map_d" | "map_tr" | "map_opacity" => self.is_transparent = true,
            "map_kd" => {
                let file = file_of(line.rest);
                if file.is_empty() {
                    return Err("expected the name of a picture after map_Kd, found none".to_owned());
                }
                self.diffuse_texture = Some(file.replace('\\', "/"));
                if file.len() < line.rest.len() {
                    return Err("the options of map_Kd are not used".to_owned());
                }
            }
            other if SILENT.contains(&other) || !says_something(other, line) => {}
            // As it is written.
            _ => {
                self.unused.insert(line.short_keyword());
            }
        }
        Ok(())
    }
}

/// Whether a line that is not used asks for more than a matte surface. Factors of zero do not, nor the numbers that
/// exporters write where nobody has set any.
fn says_something(keyword: &str, line: &Line<'_>) -> bool {
    let means_nothing = |number: f32| match keyword {
        // A matte surface, with highlights or without; 0 is one that no light changes, others mirror or are glass.
        "illum" => number == 1.0 || number == 2.0,
        "pr" | "tf" => number == 1.0,
        // Programs write the largest ambient factor beside a diffuse one.
        "ka" => number == 0.0 || number == 1.0,
        _ => number == 0.0,
    };
    line.numbers().is_none_or(|numbers| numbers.is_empty() || !numbers.into_iter().all(means_nothing))
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
    fn keywords_count_in_any_letters() {
        for text in
            ["NEWMTL a\nKD 1 0 0\nMap_Kd a.png\nD 0.5\nKE 1 1 1\n", "newmtl a\nkd 1 0 0\nMAP_KD a.png\nTR 0.5\nke 1\n"]
        {
            let (materials, notes) = read_mtl(text.as_bytes(), "a.mtl");
            let expected = MtlMaterial {
                name: "a".into(),
                diffuse: Some([1.0, 0.0, 0.0]),
                diffuse_texture: Some("a.png".into()),
                emissive: [1.0; 3],
                is_transparent: true,
                unused: BTreeSet::new(),
            };
            assert_eq!((materials, notes), (vec![expected], vec![]), "{text}");
        }
    }

    #[test]
    fn every_keyword_that_is_not_used_is_named_unless_it_says_nothing_of_a_matte_surface() {
        let notes = |lines: &str| read_mtl(format!("newmtl a\n{lines}\n").as_bytes(), "a.mtl").1;
        for (line, keyword) in [
            ("illum 0", "illum"),
            ("illum 3", "illum"),
            ("Pr 0", "Pr"),
            ("Tf 0 0 0", "Tf"),
            ("Ka 0.2 0.2 0.2", "Ka"),
            ("map_Ka a.png", "map_Ka"),
            ("map_RMA a.png", "map_RMA"),
            ("map_ORM a.png", "map_ORM"),
            ("Norm a.png", "Norm"),
            ("map_Kn a.png", "map_Kn"),
            ("something new", "something"),
            ("alone", "alone"),
        ] {
            let expected = format!("a.mtl: not used: {keyword}; surfaces are matte, of the color Kd and map_Kd");
            assert_eq!(notes(line), [expected], "{line}");
        }
        for line in ["illum 1", "illum 2", "Pr 1", "Tf 1 1 1", "Ka 1 1 1", "Ka 0 0 0", "Ks 0 0 0", "Ns 250", "Ni 1.45"]
        {
            assert_eq!(notes(line), Vec::<String>::new(), "{line}");
        }
        let many: String = (0..100).map(|k| format!("word{k} 1\n")).collect();
        assert!(notes(&many)[0].contains(" and 68 more"), "{:?}", notes(&many));
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
