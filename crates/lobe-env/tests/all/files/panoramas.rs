//! Photographs whose XMP says that they are a crop of a panorama.

use lobe_env::{EnvError, EnvMap, FisheyeOptions, MapReadOptions, Mapping, Padding, read_map_bytes};
use lobe_image::{ImageError, PictureReadOptions, ReadOption};

/// A picture of 16 x 8 texels, and one of 8 x 4.
const JPEG: &[u8] = include_bytes!("../../corpus/good/small.jpg");
const PNG: &[u8] = include_bytes!("../../corpus/good/small.png");

/// A packet of XMP with these properties, as attributes or as elements.
fn packet(properties: &[(&str, &str)], as_elements: bool) -> String {
    let (mut attributes, mut elements) = (String::new(), String::new());
    for (name, value) in properties {
        if as_elements {
            elements += &format!("<GPano:{name}>{value}</GPano:{name}>");
        } else {
            attributes += &format!(" GPano:{name}=\"{value}\"");
        }
    }
    format!(
        "<x:xmpmeta xmlns:x=\"adobe:ns:meta/\"><rdf:RDF xmlns:rdf=\"http://www.w3.org/1999/02/22-rdf-syntax-ns#\">\
         <rdf:Description rdf:about=\"\" xmlns:GPano=\"http://ns.google.com/photos/1.0/panorama/\"{attributes}>{elements}\
         </rdf:Description></rdf:RDF></x:xmpmeta>"
    )
}

/// A segment of a JPEG.
fn segment(parts: &[&[u8]]) -> Vec<u8> {
    let data = parts.concat();
    [&[0xff, 0xe1][..], &(data.len() as u16 + 2).to_be_bytes(), &data].concat()
}

/// The JPEG with segments behind its first marker.
fn jpeg(segments: &[Vec<u8>]) -> Vec<u8> {
    [&JPEG[..2], &segments.concat(), &JPEG[2..]].concat()
}

fn jpeg_with(packet: &str) -> Vec<u8> {
    jpeg(&[segment(&[b"http://ns.adobe.com/xap/1.0/\0", packet.as_bytes()])])
}

/// The JPEG with a packet in several segments, the second first.
fn jpeg_with_extended(packet: &str) -> Vec<u8> {
    let (total, half) = (packet.len() as u32, packet.len() / 2);
    let part = |from: usize, text: &[u8]| {
        let place = [total.to_be_bytes(), (from as u32).to_be_bytes()].concat();
        segment(&[b"http://ns.adobe.com/xmp/extension/\0", &[b'A'; 32], &place, text])
    };
    let (first, second) = packet.as_bytes().split_at(half);
    let main = segment(&[b"http://ns.adobe.com/xap/1.0/\0", self::packet(&[], false).as_bytes()]);
    jpeg(&[main, part(half, second), part(0, first)])
}

/// The PNG with a packet as a text.
fn png_with(packet: &str) -> Vec<u8> {
    const HEAD: usize = 8 + 25;
    let named = [b"iTXtXML:com.adobe.xmp\0\0\0\0\0".as_slice(), packet.as_bytes()].concat();
    let bit = |crc: u32, _: usize| (crc >> 1) ^ (0xedb88320 * (crc & 1));
    let crc = !named.iter().fold(!0_u32, |crc, byte| (0..8).fold(crc ^ u32::from(*byte), bit));
    let length = (named.len() - 4) as u32;
    [&PNG[..HEAD], &length.to_be_bytes(), &named, &crc.to_be_bytes(), &PNG[HEAD..]].concat()
}

const EQUIRECTANGULAR: (&str, &str) = ("ProjectionType", "equirectangular");

/// What is said of a crop of 16 x 8 or 8 x 4 at a place of a whole twice as wide and high.
fn crop(width: usize, left: &'static str, top: &'static str) -> Vec<(&'static str, &'static str)> {
    let [full_width, full_height, width, height] =
        if width == 16 { ["32", "16", "16", "8"] } else { ["16", "8", "8", "4"] };
    vec![
        EQUIRECTANGULAR,
        ("FullPanoWidthPixels", full_width),
        ("FullPanoHeightPixels", full_height),
        ("CroppedAreaImageWidthPixels", width),
        ("CroppedAreaImageHeightPixels", height),
        ("CroppedAreaLeftPixels", left),
        ("CroppedAreaTopPixels", top),
    ]
}

fn read(bytes: &[u8], options: &MapReadOptions) -> (EnvMap, Vec<String>) {
    let (map, report) = read_map_bytes(bytes, "a", options).unwrap_or_else(|e| panic!("{e}"));
    (map.into_base().into_env_map().unwrap(), report.told)
}

/// The picture itself, taken for a whole map.
fn plain(bytes: &[u8]) -> EnvMap {
    read(bytes, &MapReadOptions::default()).0
}

#[test]
fn a_crop_of_a_panorama_lies_where_its_file_says_and_the_rest_is_black() {
    let quarter = crop(16, "8", "3");
    let files = [
        ("attributes", jpeg_with(&packet(&quarter, false)), plain(JPEG)),
        ("elements", jpeg_with(&packet(&quarter, true)), plain(JPEG)),
        ("several segments", jpeg_with_extended(&packet(&quarter, false)), plain(JPEG)),
        ("PNG", png_with(&packet(&crop(8, "4", "3"), true)), plain(PNG)),
    ];
    for (what, bytes, plain) in files {
        let (map, told) = read(&bytes, &MapReadOptions::default());
        let [width, height] = [plain.width(), plain.height()];
        assert_eq!([map.width(), map.height()], [2 * width, 2 * height], "{what}: the whole sphere");
        for (x, y) in (0..2 * width).flat_map(|x| (0..2 * height).map(move |y| (x, y))) {
            let [column, row] = [x.wrapping_sub(width / 2), y.wrapping_sub(3)];
            let is_shown = column < width && row < height;
            let expected = if is_shown { plain.texel(column, row).to_array() } else { [0.0; 3] };
            assert_eq!(map.texel(x, y).to_array(), expected, "{what}: column {x}, row {y}");
        }
        assert!(told.len() == 1 && told[0].contains("XMP") && told[0].contains("black"), "{what}: {told:?}");
    }
}

#[test]
fn a_crop_that_was_scaled_afterwards_lies_where_it_did() {
    // Of a camera of 4096 columns: all around, from the zenith to 45 degrees below the horizon.
    let properties = [
        EQUIRECTANGULAR,
        ("FullPanoWidthPixels", "4096"),
        ("FullPanoHeightPixels", "2048"),
        ("CroppedAreaImageWidthPixels", "2048"),
        ("CroppedAreaImageHeightPixels", "1024"),
        ("CroppedAreaLeftPixels", "1024"),
        ("CroppedAreaTopPixels", "0"),
    ];
    let (map, told) = read(&jpeg_with(&packet(&properties, false)), &MapReadOptions::default());
    assert_eq!([map.width(), map.height()], [32, 16], "{told:?}");
    let plain = plain(JPEG);
    assert_eq!(map.texel(8, 0), plain.texel(0, 0), "the upper left corner");
    assert_eq!(map.texel(23, 7), plain.texel(15, 7), "the lower right corner");
    assert_eq!(map.texel(7, 0).to_array(), [0.0; 3], "beside it");
}

#[test]
fn a_whole_panorama_is_read_as_without_xmp_and_angles_of_the_camera_are_noted() {
    let whole = [
        EQUIRECTANGULAR,
        ("FullPanoWidthPixels", "16"),
        ("FullPanoHeightPixels", "8"),
        ("CroppedAreaImageWidthPixels", "16"),
        ("CroppedAreaImageHeightPixels", "8"),
        ("CroppedAreaLeftPixels", "0"),
        ("CroppedAreaTopPixels", "0"),
        ("PosePitchDegrees", "0.0"),
    ];
    for properties in [&whole[..], &whole[..1], &[("ProjectionType", "Equirectangular")]] {
        let (map, told) = read(&jpeg_with(&packet(properties, false)), &MapReadOptions::default());
        assert!(map == plain(JPEG) && told.is_empty(), "{properties:?}: {told:?}");
    }
    let turned = [EQUIRECTANGULAR, ("PoseHeadingDegrees", "350.5"), ("PoseRollDegrees", "-2")];
    let (map, told) = read(&jpeg_with(&packet(&turned, false)), &MapReadOptions::default());
    assert!(map == plain(JPEG) && told.len() == 2, "{told:?}");
    assert!(told[0].contains("PoseHeadingDegrees=350.5") && told[1].contains("PoseRollDegrees=-2"), "{told:?}");
}

#[test]
fn panoramas_that_cannot_be_lat_long_are_refused_unless_an_option_says_what_they_are() {
    let outside = crop(16, "8", "11");
    for (what, properties) in [("cylindrical", vec![("ProjectionType", "cylindrical")]), ("outside", outside)] {
        let bytes = jpeg_with(&packet(&properties, false));
        let error = read_map_bytes(&bytes, "a", &MapReadOptions::default()).unwrap_err();
        assert!(
            matches!(&error, EnvError::UnknownMapping { message, .. } if message.contains(what)),
            "{what}: {error}"
        );
        let (map, told) = read(&bytes, &MapReadOptions::default().mapping(Mapping::LatLong));
        assert!(map == plain(JPEG) && told.len() == 1 && told[0].contains("passed over"), "{what}: {told:?}");
    }
}

#[test]
fn xmp_that_does_not_fit_the_picture_is_noted() {
    let of_another = [
        EQUIRECTANGULAR,
        ("FullPanoWidthPixels", "4000"),
        ("FullPanoHeightPixels", "2000"),
        ("CroppedAreaImageWidthPixels", "4000"),
        ("CroppedAreaImageHeightPixels", "1000"),
        ("CroppedAreaLeftPixels", "0"),
        ("CroppedAreaTopPixels", "500"),
    ];
    let no_whole = [EQUIRECTANGULAR, ("CroppedAreaTopPixels", "500")];
    for properties in [&of_another[..], &no_whole] {
        let (map, told) = read(&jpeg_with(&packet(properties, false)), &MapReadOptions::default());
        assert!(map == plain(JPEG) && told.len() == 1 && told[0].contains("is ignored"), "{properties:?}: {told:?}");
    }
    let broken = jpeg_with(&packet(&crop(16, "0", "0"), false).replace("</rdf:RDF>", ""));
    let (_, report) = read_map_bytes(&broken, "a", &MapReadOptions::default()).unwrap();
    assert!(report.picture.notes.iter().any(|note| note.contains("XMP")), "{:?}", report.picture.notes);
}

#[test]
fn around_a_crop_there_may_be_the_light_of_its_edges() {
    let bytes = jpeg_with(&packet(&crop(16, "8", "0"), false));
    let (map, told) = read(&bytes, &MapReadOptions::default().padding(Padding::Edge));
    let plain = plain(JPEG);
    assert_eq!(map.texel(12, 15), plain.texel(4, 7), "below");
    assert_eq!([map.texel(0, 0), map.texel(31, 0)], [plain.texel(0, 0), plain.texel(15, 0)], "beside");
    assert!(told[0].contains("edges"), "{told:?}");
}

#[test]
fn a_map_that_is_made_of_a_small_picture_is_held_against_the_memory_that_is_allowed() {
    let huge = [("FullPanoWidthPixels", "23000"), ("FullPanoHeightPixels", "11500")];
    let mut properties = crop(16, "0", "0");
    properties.retain(|(name, _)| !name.starts_with("FullPano"));
    properties.extend(huge);
    // The picture itself takes 1.5 kB.
    let limited = || MapReadOptions::default().picture(PictureReadOptions::default().max_bytes(1 << 16));
    let lens = FisheyeOptions::default().circle([8.0, 4.0, 1000.0]);
    for (what, bytes, options) in [
        ("a crop", jpeg_with(&packet(&properties, false)), limited()),
        ("a strip", JPEG.to_vec(), limited().elevations([-0.001, 0.001])),
        ("a fisheye", JPEG.to_vec(), limited().fisheye(lens)),
    ] {
        match read_map_bytes(&bytes, "a", &options) {
            Err(EnvError::Image(ImageError::Refused { message, option, .. })) => {
                assert_eq!(option, ReadOption::MaxBytes, "{what}: {message}");
                assert!(message.contains("which take 65536 bytes"), "{what}: {message}");
            }
            other => panic!("{what}: {:?}", other.map(|(_, report)| report.told)),
        }
    }
}
