//! Overview of a photograph, its reconstructions and the balls that it lights, in one picture.

use crate::page::{SWEEP, Size, Sky, sheet};
use lobe::figures::lat_long_picture_of;
use lobe::image::{Picture, Tone};
use lobe::sh::Rgb;

/// Pixels between the parts.
const GAP: usize = 8;

/// Paper.
const WHITE: Rgb<f32> = Rgb::new(1.0, 1.0, 1.0);

/// Photograph and `balls` on the left, orders 1 to 6 on the right.
pub(crate) fn overview(sky: &Sky, size: Size, balls: &[Picture; 3]) -> Picture {
    let width = size.picture;
    let photograph = Tone::PHOTOGRAPH.apply(&Picture::from(&sky.map)).resized(width, width / 2);
    let ball = (width - 2 * GAP) / 3;
    let height = width / 2 + GAP + ball;

    let small = (height - 2 * GAP) / 3;
    let orders: Vec<Picture> = (1..=SWEEP)
        .map(|order| sky.tone.apply(&lat_long_picture_of(2 * small, small, &sky.radiance.resized(order))))
        .collect();
    let sheet = sheet(2, GAP, WHITE, &orders);

    let mut overview = Picture::filled(width + GAP + sheet.width(), height + 2 * GAP, WHITE);
    let gap = GAP as isize;
    overview.paste(&photograph, gap, gap);
    for (k, picture) in balls.iter().enumerate() {
        let left = gap + (k * (ball + GAP)) as isize;
        overview.paste(&picture.resized(ball, ball), left, gap + (width / 2) as isize + gap);
    }
    overview.paste(&sheet, width as isize + gap, 0);
    overview
}
