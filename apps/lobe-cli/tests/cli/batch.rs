//! Several files in one command.

use crate::harness::Dir;

#[test]
fn several_files_are_done_one_after_the_other_and_one_that_fails_stops_no_other() {
    let dir = Dir::new();
    for (name, light) in [("a.pfm", 1.0), ("b.pfm", 2.0)] {
        dir.map(name, 8, 4, |_, _| [light; 3]);
    }
    dir.file("broken.pfm", "PF\n8 4\n-1.0\n");
    let (_, notes) = dir.lobe("project a.pfm b.pfm -o out/ --order 1").succeeds();
    assert!(notes.contains("b.pfm: file 2 of 2"), "{notes}");
    for name in ["a", "b"] {
        dir.lobe(&format!("project {name}.pfm -o {name}.sh.json --order 1")).succeeds();
        let [one, batch] = ["", "out/"].map(|folder| dir.bytes(&format!("{folder}{name}.sh.json")));
        assert_eq!(one, batch, "{name}: the bytes of a command of its own");
    }
    let output = dir.lobe("env convert a.pfm broken.pfm b.pfm -o {}.exr").output();
    let line = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{line}");
    assert!(line.contains("broken.pfm: ") && line.contains("1 of 3 files failed"), "{line}");
    assert!(dir.path("a.exr").exists() && dir.path("b.exr").exists() && !dir.path("broken.exr").exists(), "{line}");
    let line = dir.lobe("project a.pfm b.pfm -o both.sh.json").error();
    assert!(line.contains("expected a folder for the results of 2 files"), "{line}");
}
