//! Commands that write one file for each of several: a line of the command for each.

use std::collections::{BTreeMap, BTreeSet};
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use anyhow::bail;
use clap::builder::OsStringValueParser;
use clap::{ArgMatches, Command};

/// What the result of a file is called in a folder.
#[derive(Clone, Copy, PartialEq)]
enum Target {
    /// Its name with another ending.
    Ending(&'static str),
    /// Its name, with its ending if that is one of a map of floats.
    Map,
    /// A folder of its name.
    Folder,
}

/// The commands, and what they write.
const COMMANDS: [(&[&str], Target); 9] = [
    (&["project"], Target::Ending("sh.json")),
    (&["export"], Target::Folder),
    (&["env", "adjust"], Target::Map),
    (&["env", "convert"], Target::Map),
    (&["env", "irradiance"], Target::Map),
    (&["env", "prefilter"], Target::Ending("ktx2")),
    (&["env", "rotate"], Target::Map),
    (&["env", "show"], Target::Ending("png")),
    (&["env", "sun"], Target::Map),
];

/// Endings of maps of floats; the first is that of results of other files.
const MAPS: [&str; 3] = ["exr", "hdr", "pfm"];

/// The arguments of files that are read and written, as the commands call them.
const INPUT: &str = "path";
const OUTPUT: &str = "output";

/// What stands for the name of a file in the arguments.
const NAME: &str = "{}";

/// A word that no file is called, to find where a file stands among the words.
const MARK: &str = "\u{1}";

const HELP: &str = "\n\nSeveral files are done one after the other, with a folder as OUT (DIR/), or with {} in its \
                    name, which stands for the name of each file: maps/{}.exr";

/// The command line with commands that take several files.
pub(crate) fn with_several(command: Command) -> Command {
    COMMANDS.iter().fold(command, |command, (names, _)| changed(command, names))
}

fn changed(command: Command, names: &[&'static str]) -> Command {
    if let Some((name, rest)) = names.split_first() {
        return command.mut_subcommand(name, |sub| changed(sub, rest));
    }
    command
        .mut_arg(INPUT, |arg| {
            let help = arg.get_help().map(ToString::to_string).unwrap_or_default();
            arg.num_args(1..).long_help(format!("{help}{HELP}"))
        })
        .mut_arg(OUTPUT, |arg| arg.value_parser(OsStringValueParser::new()))
}

/// One of the files, and the words of its command.
pub(crate) struct One {
    pub(crate) file: PathBuf,
    /// Its result; empty if that is printed.
    pub(crate) result: PathBuf,
    pub(crate) words: Vec<OsString>,
}

/// The lines of a command that `with_several` has read: none of one that names one file and its result.
pub(crate) fn lines(command: &Command, matches: &ArgMatches, words: &[OsString]) -> anyhow::Result<Vec<One>> {
    let Some((target, matches)) = COMMANDS.iter().find_map(|(names, target)| Some((*target, found(matches, names)?)))
    else {
        return Ok(vec![]);
    };
    let raw = |id| -> Vec<OsString> {
        let found = matches.try_get_raw(id).ok().flatten();
        found.into_iter().flatten().map(OsStr::to_owned).collect()
    };
    let (files, output) = (raw(INPUT), raw(OUTPUT).pop().unwrap_or_default());
    let is_folder = is_folder(&output) || has_name(&output);
    // An export is a folder by itself, and `lobe export shader` has no file.
    let is_batch = files.len() > 1 || files.len() == 1 && is_folder && target != Target::Folder;
    if !is_batch || matches.subcommand().is_some() {
        return Ok(vec![]);
    }
    // Irradiance in given directions is printed.
    let is_printed = !raw("dirs").is_empty();
    let (count, name) = (files.len(), output.display());
    if output.is_empty() && !is_printed {
        bail!("-o: expected a folder for the results of {count} files; write -o DIR/");
    }
    if output == "-" {
        bail!("-o: stdout takes the result of one file; write -o DIR/ for {count} files");
    }
    if !output.is_empty() && !is_folder && target != Target::Folder {
        bail!("-o: expected a folder for the results of {count} files, found {name}; write -o DIR/, or put {{}} in it");
    }
    if raw("light").iter().any(|light| !has_name(light)) {
        bail!("--light: expected a name of its own for each file; put {{}} in it");
    }
    let lines = Words { command, words, files: &files, output: &output, target }.lines()?;
    expect_apart(&lines)?;
    Ok(lines)
}

/// The matches of a sub-command, if it is the one that was named.
fn found<'a>(matches: &'a ArgMatches, names: &[&str]) -> Option<&'a ArgMatches> {
    let Some((name, rest)) = names.split_first() else { return Some(matches) };
    let (found, matches) = matches.subcommand()?;
    (found == *name).then(|| self::found(matches, rest))?
}

fn is_folder(output: &OsStr) -> bool {
    output.to_string_lossy().ends_with(std::path::is_separator) || Path::new(output).is_dir()
}

fn has_name(word: &OsStr) -> bool {
    word.to_str().is_some_and(|word| word.contains(NAME))
}

/// The words of a command for several files.
struct Words<'a> {
    command: &'a Command,
    words: &'a [OsString],
    files: &'a [OsString],
    output: &'a OsStr,
    target: Target,
}

impl Words<'_> {
    fn lines(&self) -> anyhow::Result<Vec<One>> {
        let inputs = self.inputs();
        let output = self.output_place();
        if output.is_none() && !self.output.is_empty() && !has_name(self.output) {
            bail!("-o: expected the folder after an option of its own; write -o {}", self.output.display());
        }
        Ok(self.files.iter().map(|file| self.line(file, &inputs, output)).collect())
    }

    /// The words of one file: the others are left out, and names are put in.
    fn line(&self, file: &OsString, inputs: &[usize], output: Option<usize>) -> One {
        let name = name_of(file);
        let mut words = Vec::with_capacity(self.words.len());
        for (at, word) in self.words.iter().enumerate() {
            match word.to_str() {
                _ if Some(&at) == inputs.first() => words.push(file.clone()),
                _ if inputs.contains(&at) => {}
                Some(text) if text.contains(NAME) => words.push(text.replace(NAME, &name.to_string_lossy()).into()),
                _ if Some(at) == output => words.push(self.in_folder(word, file, &name)),
                _ => words.push(word.clone()),
            }
        }
        let result = match self.output.to_str() {
            _ if self.output.is_empty() => PathBuf::new(),
            Some(output) if output.contains(NAME) => output.replace(NAME, &name.to_string_lossy()).into(),
            _ => self.result(file, &name),
        };
        One { file: file.into(), result, words }
    }

    /// The result of a file in the folder.
    fn result(&self, file: &OsStr, name: &OsStr) -> PathBuf {
        let mut result = name.to_owned();
        let own = Path::new(file).extension().and_then(OsStr::to_str).map(str::to_lowercase);
        match self.target {
            Target::Ending(ending) => result.push(format!(".{ending}")),
            Target::Map => {
                let kept = MAPS.iter().find(|ending| own.as_deref() == Some(ending));
                result.push(format!(".{}", kept.unwrap_or(&MAPS[0])));
            }
            Target::Folder => {}
        }
        Path::new(self.output).join(result)
    }

    /// The word that names the output, which may begin with the option: --output=DIR.
    fn in_folder(&self, word: &OsStr, file: &OsStr, name: &OsStr) -> OsString {
        let path = self.result(file, name).into_os_string();
        let option = word.to_str().zip(self.output.to_str()).and_then(|(word, output)| word.strip_suffix(output));
        let mut replaced = OsString::from(option.unwrap_or_default());
        replaced.push(path);
        replaced
    }

    /// Where the files stand among the words. A word that is also the value of an option is found by trying.
    fn inputs(&self) -> Vec<usize> {
        let mut counts: BTreeMap<&OsStr, usize> = BTreeMap::new();
        self.files.iter().for_each(|file| *counts.entry(file).or_default() += 1);
        let is_input = |at: usize| {
            let file = self.words[at].as_os_str();
            let Some(count) = counts.get(file) else { return false };
            self.words.iter().filter(|word| *word == file).count() == *count || self.is_input_by_trial(at)
        };
        (1..self.words.len()).filter(|at| is_input(*at)).collect()
    }

    fn is_input_by_trial(&self, at: usize) -> bool {
        let mut words = self.words.to_vec();
        words[at] = MARK.into();
        let Ok(matches) = self.command.clone().try_get_matches_from(words) else { return false };
        let of_command = COMMANDS.iter().find_map(|(names, _)| found(&matches, names));
        let mut raw = of_command.and_then(|matches| matches.get_raw(INPUT)).into_iter().flatten();
        raw.any(|word| word == MARK)
    }

    /// The word that ends with the output.
    fn output_place(&self) -> Option<usize> {
        let output = self.output.to_string_lossy();
        let is_it = |at: &usize| {
            let word = self.words[*at].to_string_lossy();
            let follows = |option: &str| self.words[at - 1] == option && word == output;
            let begins = |option: &str| word.strip_prefix(option).is_some_and(|rest| rest == output);
            follows("-o") || follows("--output") || begins("--output=") || begins("-o=") || begins("-o")
        };
        (1..self.words.len()).rfind(is_it)
    }
}

/// The name of a file without its ending; of a cube in six files that of their folder.
fn name_of(file: &OsStr) -> OsString {
    let text = file.to_string_lossy();
    if let Some(name) = text.strip_prefix("bundled:") {
        return name.into();
    }
    let path = Path::new(file);
    let stem = path.file_stem().unwrap_or(file);
    let folder = path.parent().and_then(Path::file_name);
    folder.filter(|_| stem.to_string_lossy().contains('%')).unwrap_or(stem).to_owned()
}

/// Refuses results that would be one file, on systems that do not tell letters by their case too, and a result that
/// would be written over one of the files.
fn expect_apart(lines: &[One]) -> anyhow::Result<()> {
    let whole = |path: &Path| path.canonicalize().unwrap_or_else(|_| path.to_owned());
    let files: BTreeSet<PathBuf> = lines.iter().map(|one| whole(&one.file)).collect();
    let mut results: BTreeMap<String, &Path> = BTreeMap::new();
    for One { file, result, .. } in lines.iter().filter(|one| !one.result.as_os_str().is_empty()) {
        let (name, at) = (file.display(), result.display());
        if let Some(other) = results.insert(result.to_string_lossy().to_lowercase(), file) {
            bail!("{name}: expected results of different names, found {at}, which is that of {} too", other.display());
        }
        if files.contains(&whole(result)) {
            bail!("{name}: its result {at} would be written over a file that is read; name another folder");
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use clap::{Arg, Command};

    use super::*;

    fn read(line: &str) -> anyhow::Result<Vec<Vec<String>>> {
        let options = [
            Arg::new(INPUT).required(true),
            Arg::new(OUTPUT).short('o').long("output"),
            Arg::new("light").long("light"),
            Arg::new("suns").long("suns"),
            Arg::new("quiet").short('q').action(clap::ArgAction::SetTrue),
        ];
        let of_env = ["adjust", "convert", "irradiance", "prefilter", "rotate", "show", "sun"];
        // Commands without --light are those that have no such argument.
        let verb = |name: &'static str| {
            let own = options.iter().filter(|arg| name == "sun" || arg.get_id() != "light");
            Command::new(name).args(own.cloned())
        };
        let env = Command::new("env").subcommands(of_env.map(verb));
        let export = verb("export").subcommand(Command::new("shader")).subcommand_negates_reqs(true);
        let command = with_several(Command::new("lobe").subcommands([verb("project"), export, env]));
        let words: Vec<OsString> = line.split(' ').map(OsString::from).collect();
        let matches = command.clone().try_get_matches_from(&words).unwrap();
        let text = |one: One| one.words.iter().map(|word| word.to_string_lossy().into_owned()).collect();
        lines(&command, &matches, &words).map(|lines| lines.into_iter().map(text).collect())
    }

    #[test]
    fn each_file_has_its_line_with_its_name_in_the_folder() {
        for (line, expected) in [
            (
                "lobe project a.hdr b/c.exr -o out/",
                ["lobe project a.hdr -o out/a.sh.json", "lobe project b/c.exr -o out/c.sh.json"],
            ),
            ("lobe env sun -o x/ a.hdr b.png", ["lobe env sun -o x/a.hdr a.hdr", "lobe env sun -o x/b.exr b.png"]),
            (
                "lobe env convert a.hdr b.hdr --output={}.ktx2",
                ["lobe env convert a.hdr --output=a.ktx2", "lobe env convert b.hdr --output=b.ktx2"],
            ),
            (
                "lobe export bundled:dusk f/%.hdr --output=out",
                ["lobe export bundled:dusk --output=out/dusk", "lobe export f/%.hdr --output=out/f"],
            ),
            (
                "lobe env sun a.hdr b.hdr --light {}.sh.json -o d/",
                ["lobe env sun a.hdr --light a.sh.json -o d/a.hdr", "lobe env sun b.hdr --light b.sh.json -o d/b.hdr"],
            ),
        ] {
            let found = read(line).unwrap();
            assert_eq!(found.iter().map(|words| words.join(" ")).collect::<Vec<_>>(), expected, "{line}");
        }
    }

    #[test]
    fn one_file_with_a_result_is_no_batch() {
        assert_eq!(read("lobe project a.hdr -o a.sh.json").unwrap().len(), 0);
        assert_eq!(read("lobe project a.hdr -o out/").unwrap().len(), 1, "a folder names the result by the file");
        assert_eq!(read("lobe export a.hdr -o out/").unwrap().len(), 0, "an export is a folder by itself");
        assert_eq!(read("lobe export shader").unwrap().len(), 0, "a command below has no files");
    }

    #[test]
    fn a_word_that_is_an_option_too_stays_where_it_is() {
        let found = read("lobe export --suns a.hdr a.hdr b.hdr -o d").unwrap();
        assert_eq!(found[0].join(" "), "lobe export --suns a.hdr a.hdr -o d/a");
        assert_eq!(found[1].join(" "), "lobe export --suns a.hdr b.hdr -o d/b");
    }

    #[test]
    fn results_that_would_be_one_are_refused() {
        for (line, part) in [
            (
                "lobe project a/x.hdr b/x.hdr -o out/",
                "b/x.hdr: expected results of different names, found out/x.sh.json, which is that of a/x.hdr",
            ),
            ("lobe project a.hdr b.hdr -o a.sh.json", "expected a folder for the results of 2 files, found a.sh.json"),
            ("lobe project a/x.hdr b/X.exr -o out/", "expected results of different names"),
            ("lobe project a.hdr b.hdr", "write -o DIR/"),
            ("lobe project a.hdr b.hdr -o -", "stdout takes the result of one file"),
            ("lobe project a.hdr b.hdr -qo out/", "write -o out/"),
            ("lobe env rotate k.hdr k_x.hdr -o {}_x.hdr", "k.hdr: its result k_x.hdr would be written over a file"),
            ("lobe env sun a.hdr b.hdr -o d/ --light=sun.sh.json", "--light: expected a name of its own"),
            ("lobe env sun a.hdr b.hdr -o d/ --light sun.sh.json", "--light: expected a name of its own"),
        ] {
            let message = read(line).unwrap_err().to_string();
            assert!(message.contains(part), "{line}: {message}");
        }
    }
}
