//! Test harness of the command: a temporary folder, and commands that run in it.

use std::fs;
use std::io::Write as _;
use std::path::PathBuf;
use std::process::{Command, ExitStatus, Output, Stdio};

use lobe::env::{EnvMap, PictureWriteOptions, write_env};
use lobe::prt::{Baked, read_baked};
use lobe::sh::Rgb;
use lobe::sh::expansion::Quantity;
use lobe::sh::sh_json::{FileCoefficients, ShFile, read_sh_json, write_sh_json};
use lobe_testkit::{glb_faults, glb_unused};
use tempfile::TempDir;

/// A folder that is removed at the end of the test.
pub(crate) struct Dir {
    folder: TempDir,
}

impl Dir {
    pub(crate) fn new() -> Self {
        Self { folder: tempfile::tempdir().unwrap() }
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// Writes a file as it is given.
    pub(crate) fn file(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).unwrap();
    }

    /// Reads a file.
    pub(crate) fn bytes(&self, name: &str) -> Vec<u8> {
        fs::read(self.path(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
    }

    /// Reads a baked scene, whose file has to be right by glTF's rules.
    pub(crate) fn baked(&self, name: &str) -> Baked {
        assert_eq!(glb_faults(&self.bytes(name)), Vec::<String>::new(), "faults of {name}");
        assert_eq!(glb_unused(&self.bytes(name)), Vec::<String>::new(), "what nothing names in {name}");
        read_baked(self.path(name), &lobe::scene::SceneReadOptions::default()).unwrap()
    }

    /// Writes an expansion.
    pub(crate) fn sh(&self, name: &str, quantity: Quantity, f: impl Into<FileCoefficients>) {
        write_sh_json(self.path(name), &ShFile::new(quantity, f)).unwrap();
    }

    /// Reads an expansion.
    pub(crate) fn read_sh(&self, name: &str) -> ShFile {
        read_sh_json(self.path(name)).unwrap()
    }

    /// All numbers of a picture.
    pub(crate) fn numbers(&self, name: &str) -> Vec<f32> {
        let (picture, _) = lobe::image::read_picture(self.path(name), &Default::default()).unwrap();
        picture.pixels().as_flattened().to_vec()
    }

    /// Writes an environment map; the name's extension decides the format.
    pub(crate) fn map(&self, name: &str, width: usize, height: usize, texel: impl Fn(usize, usize) -> [f32; 3]) {
        let texels = (0..width * height).map(|i| Rgb::from(texel(i % width, i / width))).collect();
        let map = EnvMap::new(width, height, texels).unwrap();
        write_env(self.path(name), &map, &PictureWriteOptions::default()).unwrap();
    }

    /// The names of all files, in order.
    pub(crate) fn names(&self) -> Vec<String> {
        let entries = fs::read_dir(self.folder.path()).unwrap();
        let mut names: Vec<_> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// The command `lobe` with these arguments, which are separated by blanks.
    pub(crate) fn lobe(&self, args: &str) -> TestCommand {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lobe"));
        command.args(args.split_whitespace()).current_dir(self.folder.path());
        TestCommand { command, args: args.to_owned(), stdin: Vec::new() }
    }
}

/// The mean of numbers.
pub(crate) fn mean(numbers: &[f32]) -> f64 {
    numbers.iter().map(|x| f64::from(*x)).sum::<f64>() / numbers.len() as f64
}

/// One run of `lobe`.
pub(crate) struct TestCommand {
    command: Command,
    args: String,
    stdin: Vec<u8>,
}

impl TestCommand {
    /// The bytes that the command reads on stdin; none unless this is called.
    pub(crate) fn stdin(mut self, bytes: impl Into<Vec<u8>>) -> Self {
        self.stdin = bytes.into();
        self
    }

    /// One more argument, which may hold blanks.
    pub(crate) fn arg(mut self, arg: &str) -> Self {
        self.command.arg(arg);
        self.args = format!("{} '{arg}'", self.args);
        self
    }

    /// A variable of the command's environment.
    pub(crate) fn env(mut self, name: &str, value: &str) -> Self {
        self.command.env(name, value);
        self
    }

    /// Runs the command.
    pub(crate) fn output(mut self) -> Output {
        let command = self.command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        // A command that fails early does not read; that is no error of the test.
        let _ = child.stdin.take().unwrap().write_all(&self.stdin);
        child.wait_with_output().unwrap()
    }

    /// Runs the command; what it returns, stdout, and stderr but for lines of progress, of which a slow machine has more.
    fn texts(self) -> (ExitStatus, String, String) {
        let Output { status, stdout, stderr } = self.output();
        let [stdout, stderr] = [stdout, stderr].map(|bytes| String::from_utf8(bytes).unwrap());
        let lines = stderr.split_inclusive('\n').filter(|line| !line.starts_with("progress: "));
        (status, stdout, lines.collect())
    }

    /// Runs the command, which must succeed; stdout and stderr.
    pub(crate) fn succeeds(self) -> (String, String) {
        let args = self.args.clone();
        let (status, stdout, stderr) = self.texts();
        assert_eq!(status.code(), Some(0), "exit code of lobe {args}; stderr: {stderr}");
        (stdout, stderr)
    }

    /// Runs the command, which must succeed and print nothing on stderr; its stdout.
    pub(crate) fn stdout(self) -> String {
        let args = self.args.clone();
        let (stdout, stderr) = self.succeeds();
        assert_eq!(stderr, "", "stderr of lobe {args}");
        stdout
    }

    /// Runs the command, which must exit with 2, print nothing on stdout and one line `lobe: ...` on stderr; that line
    /// without `lobe: `.
    pub(crate) fn error(self) -> String {
        let args = self.args.clone();
        let (status, stdout, stderr) = self.texts();
        assert_eq!(status.code(), Some(2), "exit code of lobe {args}; stderr: {stderr}");
        assert_eq!(stdout, "", "stdout of lobe {args}");
        let line = stderr.strip_prefix("lobe: ").and_then(|rest| rest.strip_suffix('\n'));
        let line = line.unwrap_or_else(|| panic!("stderr of lobe {args} is no line of ours: {stderr:?}"));
        assert!(!line.contains('\n'), "stderr of lobe {args} has more than one line: {stderr:?}");
        line.to_owned()
    }
}

/// A .hdr file with rows one after the other and no compression: its header, then `pixels` of red, green, blue and
/// exponent.
pub(crate) fn flat_hdr(width: usize, height: usize, pixels: &[[u8; 4]]) -> Vec<u8> {
    let mut bytes = format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y {height} +X {width}\n").into_bytes();
    bytes.extend(pixels.iter().flatten());
    bytes
}

/// The RGBE pixel of radiance 1.
pub(crate) const ONE: [u8; 4] = [128, 128, 128, 129];
