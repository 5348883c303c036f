//! The page in a folder, and the pictures of the documents.

#![allow(clippy::unwrap_used, reason = "a helper of a test that cannot do its work has found a failure")]

use std::fs;
use std::io::BufReader;
use std::ops::ControlFlow;
use std::path::Path;

use lobe::image::Tone;
use lobe::io::{Job, Progress};
use lobe_gallery::{GalleryError, Size, document_pictures, write_gallery};

#[test]
fn every_file_that_the_page_shows_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let mut reported = Vec::new();
    let mut watch = |progress: &Progress| {
        reported.push((progress.done, progress.total));
        ControlFlow::Continue(())
    };
    let index = write_gallery(folder.path(), Size::LEAST, Job::default().watched_by(&mut watch)).unwrap();
    let &(steps, total) = reported.last().unwrap();
    assert_eq!((steps, reported[0]), (total, (0, total)), "what is reported at the beginning is true at the end");
    let html = fs::read_to_string(index).unwrap();
    assert!(!html.contains("http-equiv"), "a complete page does not ask to be loaded again");
    let shown: Vec<&str> = html.split("<img src=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    assert!(shown.len() > 100, "{} figures: {shown:?}", shown.len());
    for file in shown {
        let bytes = fs::read(folder.path().join(file)).unwrap();
        if file.ends_with(".svg") {
            assert!(bytes.starts_with(b"<svg ") && bytes.ends_with(b"</svg>\n"), "{file}");
            assert!(!String::from_utf8(bytes).unwrap().contains("NaN"), "{file}");
        } else {
            assert_eq!(&bytes[1..4], b"PNG", "{file}");
        }
    }
}

#[test]
fn a_job_that_is_stopped_leaves_a_page_that_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let mut watch = |progress: &Progress| match progress.done {
        // In the middle of the third section.
        10 => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    let stopped = write_gallery(folder.path(), Size::LEAST, Job::default().watched_by(&mut watch));
    assert!(matches!(stopped, Err(GalleryError::Cancelled)), "{stopped:?}");
    let html = fs::read_to_string(folder.path().join("index.html")).unwrap();
    assert!(html.contains("http-equiv") && html.contains("More is being made"), "{html}");
    assert!(html.contains("what n² numbers remember") && !html.contains("nine numbers light a ball"), "{html}");
}

#[test]
fn a_job_with_a_checkpoint_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let refused = write_gallery(folder.path(), Size::LEAST, Job::default().kept_in("kept")).unwrap_err().to_string();
    assert!(refused.starts_with("expected no checkpoint"), "{refused}");
}

/// The columns and rows of a PNG file of three colors, and its bytes.
fn pixels_of(path: &Path) -> ([usize; 2], Vec<u8>) {
    let file = fs::File::open(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut reader = png::Decoder::new(BufReader::new(file)).read_info().unwrap();
    assert_eq!(reader.output_color_type(), (png::ColorType::Rgb, png::BitDepth::Eight), "{}", path.display());
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    reader.next_frame(&mut pixels).unwrap();
    let (columns, rows) = reader.info().size();
    ([columns as usize, rows as usize], pixels)
}

#[test]
fn the_pictures_in_the_documents_are_drawn_by_this_code() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let pictures = document_pictures().unwrap();
    assert_eq!(pictures.len(), 9, "the overview and eight mappings");
    for (path, drawn) in pictures {
        let (kept_size, kept) = pixels_of(&root.join(&path));
        assert_eq!(kept_size, [drawn.width(), drawn.height()], "{path}: draw them anew by the example `documents`");
        let bytes = Tone::PLAIN.to_bytes(&drawn);
        // The sine of another machine's library may put a sample on the other side of a line.
        let differing = kept.iter().zip(&bytes).filter(|(a, b)| a.abs_diff(**b) > 2).count();
        assert!(differing * 500 < bytes.len(), "{path}: {differing} of {} bytes differ", bytes.len());
    }
    for mapping in fs::read_dir(root.join("docs/figures/mappings")).unwrap() {
        let file = mapping.unwrap();
        let length = file.metadata().unwrap().len();
        assert!(length <= 40 * 1024, "{}: {length} bytes", file.path().display());
    }
}
