//! Suns as lights of a stage of `OpenUSD`.

use lobe_sh::Dir;
use lobe_sh::encoding::EngineFrame;
use lobe_sh::rotation::tangent_frame;

use crate::sky::sun_extraction::Sun;

/// Distant lights, which shine along their own -z: the rows of a matrix are where it takes the axes. Light is
/// normalized by the angle, so that intensity times color is irradiance.
pub(crate) fn usd_lights(frame: EngineFrame, suns: &[Sun]) -> String {
    suns.iter().enumerate().map(|(k, sun)| usd_light(frame, &format!("Sun{}", k + 1), sun)).collect()
}

fn usd_light(frame: EngineFrame, name: &str, sun: &Sun) -> String {
    let irradiance = sun.irradiance.to_array();
    let intensity = irradiance.into_iter().fold(f64::MIN_POSITIVE, f64::max);
    let turn = tangent_frame(frame.dir(sun.direction));
    let rows = [Dir::X, Dir::Y, Dir::Z].map(|axis| format!("({}, 0)", numbers(turn.rotate_dir(axis).to_array())));
    [
        format!("\n    def DistantLight \"{name}\"\n    {{\n"),
        format!("        float inputs:angle = {}\n", sun.angular_diameter.to_degrees() as f32),
        format!("        color3f inputs:color = ({})\n", numbers(irradiance.map(|c| c / intensity))),
        format!("        float inputs:intensity = {}\n", intensity as f32),
        "        bool inputs:normalize = 1\n".to_owned(),
        format!("        matrix4d xformOp:transform = ( {}, (0, 0, 0, 1) )\n", rows.join(", ")),
        "        uniform token[] xformOpOrder = [\"xformOp:transform\"]\n    }\n".to_owned(),
    ]
    .concat()
}

/// Numbers to the seven digits that `f32` has after the point; rounding leaves no -0.
fn numbers(values: [f64; 3]) -> String {
    values.map(|c| ((c * 1e7).round() / 1e7 + 0.0).to_string()).join(", ")
}

#[cfg(test)]
mod tests {
    use lobe_sh::Rgb;

    use super::*;

    #[test]
    fn a_light_points_its_third_row_towards_the_sun_and_intensity_times_color_is_irradiance() {
        let direction = Dir::new([0.6, 0.0, 0.8]).unwrap();
        let sun =
            Sun { direction, irradiance: Rgb::new(1.0, 4.0, 2.0), angular_diameter: 1_f64.to_radians(), texels: 0 };
        let text = usd_lights(EngineFrame::YUp, &[sun]);
        // Up in Lobe is +z, and +y of the stage.
        assert!(text.contains("(0.6, 0.8, 0, 0), (0, 0, 0, 1) )"), "{text}");
        assert!(text.contains("color = (0.25, 1, 0.5)") && text.contains("intensity = 4\n"), "{text}");
        assert!(text.contains("angle = 1\n"), "{text}");
    }
}
