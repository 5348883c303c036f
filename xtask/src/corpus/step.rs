//! One run of the command on one file, within limits of time and memory.

use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Time that a run may take.
const TIME: Duration = Duration::from_secs(120);

/// Address space that a run may take, in KiB.
const MEMORY: &str = "6291456";

/// How a run ended.
#[derive(Debug, PartialEq)]
pub(super) enum End {
    Done,
    /// One line on stderr and exit code 2, as is promised: the line.
    Refused(String),
    /// Anything else.
    Failed(String),
}

/// Runs a program; `stdout` and `stderr` are those of a run, by what the command promises.
pub(super) fn run(program: &Path, arguments: &[&str], folder: &Path) -> (End, Duration) {
    let start = Instant::now();
    let end = run_within_limits(program, arguments, folder, start).unwrap_or_else(End::Failed);
    (end, start.elapsed())
}

fn run_within_limits(program: &Path, arguments: &[&str], folder: &Path, start: Instant) -> Result<End, String> {
    let said = folder.join("stderr.txt");
    let file = std::fs::File::create(&said).map_err(|error| format!("{}: {error}", said.display()))?;
    let mut child = Command::new("sh")
        .args(["-c", &format!("ulimit -v {MEMORY}; exec \"$@\""), "sh"])
        .arg(program)
        .args(arguments)
        .current_dir(folder)
        .stdout(Stdio::null())
        .stderr(file)
        .spawn()
        .map_err(|error| format!("sh did not start: {error}"))?;
    let status = loop {
        if let Some(status) = child.try_wait().map_err(|error| error.to_string())? {
            break status;
        }
        if start.elapsed() > TIME {
            child.kill().and_then(|()| child.wait()).map_err(|error| error.to_string())?;
            return Err(format!("took more than {} s", TIME.as_secs()));
        }
        sleep(Duration::from_millis(5));
    };
    let text = std::fs::read(&said).map_err(|error| format!("{}: {error}", said.display()))?;
    Ok(end(status.code(), String::from_utf8_lossy(&text).trim()))
}

/// The meaning of an exit code, none after a signal, and of what was said.
fn end(code: Option<i32>, said: &str) -> End {
    match code {
        Some(0) => End::Done,
        Some(2) if !said.contains('\n') && said.starts_with("lobe: ") => End::Refused(said["lobe: ".len()..].into()),
        Some(code) => End::Failed(format!("exit code {code}: {said}")),
        None => End::Failed(format!("ended by a signal: {said}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_one_line_and_code_2_is_a_refusal() {
        assert_eq!(end(Some(0), ""), End::Done, "code 0");
        assert_eq!(end(Some(2), "lobe: a.glb: no triangles"), End::Refused("a.glb: no triangles".into()), "code 2");
        for (code, said) in [(Some(2), "lobe: a\nb"), (Some(2), ""), (Some(101), "lobe: a"), (None, "lobe: a")] {
            assert!(matches!(end(code, said), End::Failed(_)), "{code:?} {said:?}");
        }
    }

    #[test]
    fn a_program_ends_as_its_exit_code_says() {
        let folder = std::env::temp_dir();
        let run = |code: &str| run(Path::new("sh"), &["-c", code], &folder).0;
        assert_eq!(run("exit 0"), End::Done, "code 0");
        assert_eq!(run("echo lobe: no >&2; exit 2"), End::Refused("no".into()), "refusal");
        assert!(matches!(run("kill -9 $$"), End::Failed(_)), "a signal");
    }
}
