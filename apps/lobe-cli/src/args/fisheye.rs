//! Fisheye pictures as inputs: the lens, where it looked, and the circle.

use clap::Args;
use lobe::env::{FisheyeOptions, FisheyeProjection};
use lobe::sh::Dir;

use crate::args::input::READING;
use crate::args::values;

/// How a fisheye picture shows its surroundings.
#[derive(Args)]
pub(crate) struct FisheyeInput {
    /// The picture is that of a fisheye lens, and shows in its largest circle as many degrees as FOV says [default: 180].
    /// PROJECTION is equidistant (r = f t, t the angle to the axis), equisolid (2 f sin t/2), stereographic (2 f tan t/2, below
    /// 360 degrees) or orthographic (f sin t, to 180 degrees). It becomes a lat-long map of everything around
    #[arg(long, value_name = "PROJECTION[:FOV]", value_parser = lens, group = "shown_part")]
    #[arg(help_heading = READING, hide_short_help = true)]
    #[arg(conflicts_with_all = ["from", "from_left_handed"])]
    fisheye: Option<FisheyeOptions>,
    /// With --fisheye: where the lens looked, which is in the middle. The top of the picture points to +x if that is steeply
    /// up or down, else to +z; a picture of the sky has +y on its right, one of the ground -y
    #[arg(long, value_name = "up|down|X,Y,Z", value_parser = axis, default_value = "up", requires = "fisheye")]
    #[arg(help_heading = READING, hide_short_help = true)]
    #[arg(allow_hyphen_values = true)]
    fisheye_axis: Dir,
    /// With --fisheye: column and row of the middle of the circle and its radius, in pixels from the upper left corner
    /// [default: the largest circle about the middle of the picture]
    #[arg(long, value_name = "X,Y,R", value_parser = circle, requires = "fisheye")]
    #[arg(help_heading = READING, hide_short_help = true)]
    fisheye_circle: Option<[f64; 3]>,
}

impl FisheyeInput {
    /// No fisheye picture.
    pub(crate) fn none() -> Self {
        Self { fisheye: None, fisheye_axis: Dir::Z, fisheye_circle: None }
    }

    /// The options of reading a fisheye picture, if it is one.
    pub(crate) fn options(&self) -> Option<FisheyeOptions> {
        self.fisheye.map(|lens| lens.axis(self.fisheye_axis).circle(self.fisheye_circle))
    }
}

/// The lens of `PROJECTION` or `PROJECTION:FOV`, which is in degrees.
fn lens(text: &str) -> Result<FisheyeOptions, String> {
    let (name, degrees) = text.split_once(':').map_or((text, None), |(name, degrees)| (name, Some(degrees)));
    let names = FisheyeProjection::ALL.map(FisheyeProjection::name).join(", ");
    let projection =
        FisheyeProjection::from_name(name).ok_or_else(|| format!("expected one of {names}, found {name:?}"))?;
    let field_of_view = degrees.map_or(Ok(180.0), values::finite)?.to_radians();
    projection.check_field_of_view(field_of_view).map_err(|e| e.to_string())?;
    Ok(FisheyeOptions::default().projection(projection).field_of_view(field_of_view))
}

/// A direction, for which there are two words.
fn axis(text: &str) -> Result<Dir, String> {
    match text {
        "up" => Ok(Dir::Z),
        "down" => Ok(-Dir::Z),
        _ => values::dir(text),
    }
}

/// A circle of a radius above 0.
fn circle(text: &str) -> Result<[f64; 3], String> {
    let circle: [f64; 3] = values::numbers(text)?;
    if circle[2] > 0.0 { Ok(circle) } else { Err(format!("expected a radius above 0, found {}", circle[2])) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_lens_is_a_projection_and_degrees_within_its_limits() {
        let found = lens("equisolid").unwrap();
        assert_eq!(
            (found.projection, found.field_of_view),
            (FisheyeProjection::Equisolid, 180_f64.to_radians()),
            "half"
        );
        for projection in FisheyeProjection::ALL {
            let found = lens(&format!("{projection}:170.5")).unwrap();
            assert_eq!((found.projection, found.field_of_view), (projection, 170.5_f64.to_radians()), "{projection}");
        }
        for (text, part) in [
            ("round", "expected one of equidistant, equisolid, stereographic, orthographic, found \"round\""),
            ("", "found \"\""),
            ("equisolid:", "expected a finite number"),
            ("equisolid:x", "expected a finite number"),
            ("equisolid:0", "above 0°"),
            ("equisolid:361", "at most 360°"),
            ("stereographic:360", "less than 360°"),
            ("orthographic:181", "at most 180°"),
        ] {
            let message = lens(text).unwrap_err();
            assert!(message.contains(part), "{text:?}: {message}");
        }
    }

    #[test]
    fn the_axis_is_a_word_or_a_direction_and_the_circle_has_a_radius() {
        assert_eq!([axis("up"), axis("down"), axis("0,-2,0")], [Ok(Dir::Z), Ok(-Dir::Z), Ok(-Dir::Y)], "axes");
        assert!(axis("0,0,0").is_err() && axis("north").is_err(), "no direction");
        assert_eq!(circle("10.5,20,5"), Ok([10.5, 20.0, 5.0]), "a circle");
        assert!(circle("1,2,0").is_err() && circle("1,2").is_err(), "no circle");
    }
}
