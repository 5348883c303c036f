//! Cubes as sources of filters.

use std::borrow::Cow;

use lobe_io::Job;

use crate::error::EnvError;
use crate::map::cube_map::CubeMap;
use crate::map::mapped_map::MappedMap;
use crate::mapping::mapping::Mapping;
use crate::resample::resample::Resample;
use crate::resample::resample::resample;

/// A source this many times as fine as the result loses nothing that a mirror of the result's size would show.
const OVERSAMPLING: usize = 2;

/// A map as a cube that is fine enough to be [prefiltered](crate::prefilter_ggx) to faces of `size`: twice as fine, but
/// no finer than the map. A lat-long map is as fine as a cube on whose faces a quarter of its horizon falls, a map of
/// another mapping at least as one of [as many texels](MappedMap::size_like). A cube stays as it is.
///
/// # Errors
/// As [`resample`].
pub fn cube_source<'a>(map: impl Into<Cow<'a, MappedMap>>, size: usize, job: Job<'_>) -> Result<CubeMap, EnvError> {
    let map = map.into();
    if map.mapping() == Mapping::Cube {
        return map.into_owned().into_cube_map();
    }
    let size = OVERSAMPLING.saturating_mul(size.next_power_of_two()).min(finest(&map)).max(1);
    resample(map, &Resample::to(Mapping::Cube, size, Mapping::Cube.height_for(size)), job)?.into_cube_map()
}

/// The size of faces that show all detail of a map.
fn finest(map: &MappedMap) -> usize {
    let of_horizon = (map.width() / 4).next_power_of_two();
    if map.mapping() == Mapping::LatLong { of_horizon } else { map.size_like(Mapping::Cube).max(of_horizon) }
}

#[cfg(test)]
mod tests {
    use lobe_sh::{Coefficient as _, Rgb};

    use super::*;

    #[test]
    fn a_source_is_twice_as_fine_as_the_result_and_no_finer_than_the_map() {
        let lat_long = |width| MappedMap::from_fn(Mapping::LatLong, width, width / 2, |_| Rgb::splat(1.0));
        for (width, size, expected) in [(64, 4, 8), (64, 5, 16), (64, 64, 16), (8, 64, 2), (2, 1, 1)] {
            let cube = cube_source(lat_long(width), size, Job::default()).unwrap();
            assert_eq!(cube.width(), expected, "a map of {width} texels for faces of {size}");
        }
        // Six faces of 16 x 16 have about as many texels.
        for mapping in [Mapping::Octahedral, Mapping::EqualArea, Mapping::Angular, Mapping::MirrorBall] {
            let map = MappedMap::from_fn(mapping, 32, 32, |_| Rgb::splat(1.0));
            for (size, expected) in [(4, 8), (64, 16)] {
                let cube = cube_source(&map, size, Job::default()).unwrap();
                assert_eq!(cube.width(), expected, "a map that is {mapping} for faces of {size}");
            }
        }
        let cube = MappedMap::from_fn(Mapping::Cube, 3, 18, |s| Rgb::splat(s.z() as f32));
        assert!(*cube_source(&cube, 64, Job::default()).unwrap() == cube, "a cube stays as it is");
    }
}
