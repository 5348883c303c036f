//! An expansion; what is read is written and read again.
#![no_main]

use libfuzzer_sys::fuzz_target;
use lobe_sh::sh_json::{read_sh_json_bytes, write_sh_json_to};

fuzz_target!(|bytes: &[u8]| match read_sh_json_bytes(bytes, "fuzz") {
    Ok(file) => {
        let mut text = Vec::new();
        write_sh_json_to(&mut text, &file, "fuzz").expect("what was read can be written");
        let again = read_sh_json_bytes(&text, "fuzz").expect("what was written can be read");
        assert_eq!(again, file, "read, written and read again");
    }
    Err(error) => {
        let line = error.to_string();
        assert!(line.starts_with("fuzz: ") && !line.contains('\n'), "{line:?}");
    }
});
