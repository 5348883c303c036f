//! `lobe man` and `lobe completions`.

use std::process::Command;

use crate::harness::Dir;

/// The commands that `lobe --help` lists, or those of another command.
fn commands(dir: &Dir, of: &str) -> Vec<String> {
    let help = dir.lobe(&format!("{of} --help")).stdout();
    let (_, list) = help.split_once("Commands:\n").unwrap();
    let lines = list.lines().take_while(|line| !line.trim().is_empty());
    // The explanation of a command may go on in lines that are indented further.
    let names = lines.filter(|line| line.starts_with("  ") && !line.starts_with("   "));
    names.filter_map(|line| line.split_whitespace().next()).filter(|name| *name != "help").map(String::from).collect()
}

/// The full names of a command and of all below it, as `lobe sh eval`.
fn with_those_below(dir: &Dir, command: &str) -> Vec<String> {
    let mut all = vec![format!("lobe {command}").trim().to_string()];
    if dir.lobe(&format!("{command} --help")).stdout().contains("Commands:\n") {
        for sub in commands(dir, command) {
            all.extend(with_those_below(dir, format!("{command} {sub}").trim()));
        }
    }
    all
}

#[test]
fn every_command_has_a_page_that_names_its_options() {
    let dir = Dir::new();
    assert_eq!(dir.lobe("man -o pages/man1").stdout(), "", "stdout");
    let page = |name: &str| String::from_utf8(dir.bytes(&format!("pages/man1/{name}.1"))).unwrap();
    let all = with_those_below(&dir, "");
    for command in &all {
        let text = page(&command.replace(' ', "-"));
        for part in [".SH NAME", ".SH SYNOPSIS", ".SH OPTIONS"] {
            assert!(text.contains(part), "{command}: no {part} in {text}");
        }
    }
    let files = std::fs::read_dir(dir.path("pages/man1")).unwrap().count();
    assert!(files == all.len() && files > 30, "{files} pages for {} commands", all.len());
    assert!(page("lobe-sh-eval").contains("\\-\\-dir"), "options are named");
    assert_eq!(dir.lobe("man").stdout(), page("lobe"), "the page of lobe itself goes to stdout");
}

#[test]
fn a_folder_that_cannot_be_made_is_refused_with_the_reason() {
    let dir = Dir::new();
    dir.file("file", "");
    assert_eq!(dir.lobe("man -o file/x").error(), "file/x: cannot be made: Not a directory (os error 20)", "said");
}

/// Runs a program of the system; what it printed, stdout and stderr, or none where it is not installed.
fn try_run(dir: &Dir, program: &str, args: &[&str]) -> Option<[String; 2]> {
    match Command::new(program).args(args).current_dir(dir.path("")).output() {
        Ok(output) => Some([output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned())),
        Err(_) => {
            lobe_testkit::skipped(&format!("manual pages by {program}, which is not installed"));
            None
        }
    }
}

#[test]
fn man_shows_the_pages_without_a_warning() {
    let dir = Dir::new();
    dir.lobe("man -o pages").stdout();
    let page = String::from_utf8(dir.bytes("pages/lobe-env-adjust.1")).unwrap();
    assert!(page.contains("fisheye"), "a page has the options that short help leaves out");
    let pages =
        dir.path("pages").read_dir().unwrap().map(|page| format!("pages/{}", page.unwrap().file_name().display()));
    let pages: Vec<String> = pages.collect();
    let args: Vec<&str> = ["--warnings", "-Tutf8", "-l"].into_iter().chain(pages.iter().map(String::as_str)).collect();
    let Some([shown, warnings]) = try_run(&dir, "man", &args) else { return };
    assert_eq!(warnings, "", "warnings of man");
    assert!(shown.contains("lobe-sh-eval"), "{} bytes shown", shown.len());
}

#[test]
fn bash_completes_commands_and_options() {
    let dir = Dir::new();
    dir.file("lobe.bash", dir.lobe("completions bash").stdout());
    let completed = "source lobe.bash; complete -p lobe; COMP_WORDS=(lobe sh eval --d); COMP_CWORD=3; _lobe lobe --d eval; \
                     echo \"${COMPREPLY[@]}\"";
    let Some([stdout, stderr]) = try_run(&dir, "bash", &["-c", completed]) else { return };
    assert_eq!(stderr, "", "stderr of bash");
    let lines: Vec<&str> = stdout.lines().collect();
    assert!(lines[0].starts_with("complete ") && lines[0].ends_with(" -F _lobe lobe"), "{stdout}");
    assert_eq!(lines[1], "--dir", "{stdout}");
}

#[test]
fn shells_are_told_commands_and_options() {
    let dir = Dir::new();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = dir.lobe(&format!("completions {shell}")).stdout();
        for word in ["fit-lobes", "vector-irradiance", "max-memory"] {
            assert!(script.contains(word), "{shell}: {word} is not in {} bytes", script.len());
        }
    }
    let line = dir.lobe("completions csh").error();
    assert!(line.contains("possible values: bash, elvish, fish, powershell, zsh"), "{line}");
}
