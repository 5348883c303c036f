//! Writing files so that nothing half-written ever has the final name.

use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::mem;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use tempfile::{Builder, NamedTempFile};

/// Writes a file through a temporary one in the same folder, which takes the final name only when `write` has
/// succeeded and the bytes have reached the disk. If anything fails, what stood under `path` is untouched.
///
/// A new file gets the usual permissions of the user, a replaced one keeps its own. A link is followed. What is
/// neither file nor folder (a pipe, `/dev/null`) is written in place. A program that a signal ends while it writes leaves the
/// temporary file, unless it calls [`remove_unfinished`]; the next [`remove_abandoned`] takes it away.
///
/// # Errors
/// If the folder does not exist or cannot be written, if `path` is a folder, or if `write` or the disk fails.
pub fn write_atomically(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<()> {
    StagedFile::write(path, write)?.publish()
}

/// The first half of [`write_atomically`]: a file that is on the disk and waits for its name. Several of them are written
/// before the first is published, where one is worth nothing without the others. Dropped instead, it is gone.
#[derive(Debug)]
pub struct StagedFile {
    /// `None` if it was written in place.
    waiting: Option<(Temporary, PathBuf)>,
}

impl StagedFile {
    /// Writes the file that shall stand under `path`.
    ///
    /// # Errors
    /// Those of [`write_atomically`].
    pub fn write(path: &Path, write: impl FnOnce(&mut dyn Write) -> io::Result<()>) -> io::Result<Self> {
        let mut writer = StagedWriter::new(path)?;
        write(&mut writer)?;
        writer.finish()
    }

    /// Gives the file its name.
    ///
    /// # Errors
    /// If the system refuses.
    pub fn publish(self) -> io::Result<()> {
        match self.waiting {
            Some((temporary, path)) => temporary.persist(&path),
            None => Ok(()),
        }
    }
}

/// A [`StagedFile`] in the making, for what is written bit by bit as it comes. Dropped instead of finished, it is gone.
#[derive(Debug)]
pub struct StagedWriter(Staged);

#[derive(Debug)]
enum Staged {
    InPlace(BufWriter<File>),
    /// The temporary file is written by its handle: by itself it puts its own name before the refusals of the system.
    Replace {
        buffered: BufWriter<File>,
        temporary: Temporary,
        path: PathBuf,
    },
}

impl StagedWriter {
    /// Begins the file that shall stand under `path`.
    ///
    /// # Errors
    /// Those of [`write_atomically`].
    pub fn new(path: &Path) -> io::Result<Self> {
        if let Some(prepare) = BEFORE_WRITING.get() {
            prepare();
        }
        Ok(Self(match Target::of(path)? {
            Target::InPlace(path) => Staged::InPlace(BufWriter::new(File::options().write(true).open(path)?)),
            Target::Replace(path) => {
                let temporary = temporary_beside(&path)?;
                Staged::Replace { buffered: BufWriter::new(temporary.as_file()?.try_clone()?), temporary, path }
            }
        }))
    }

    /// Brings the bytes to the disk, where they wait for their name.
    ///
    /// # Errors
    /// Those of [`write_atomically`].
    pub fn finish(self) -> io::Result<StagedFile> {
        match self.0 {
            Staged::InPlace(mut buffered) => {
                buffered.flush()?;
                Ok(StagedFile { waiting: None })
            }
            Staged::Replace { mut buffered, temporary, path } => {
                buffered.flush()?;
                if let Ok(old) = path.metadata() {
                    temporary.as_file()?.set_permissions(old.permissions())?;
                }
                temporary.as_file()?.sync_all()?;
                Ok(StagedFile { waiting: Some((temporary, path)) })
            }
        }
    }
}

impl Write for StagedWriter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.0 {
            Staged::InPlace(buffered) | Staged::Replace { buffered, .. } => buffered.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match &mut self.0 {
            Staged::InPlace(buffered) | Staged::Replace { buffered, .. } => buffered.flush(),
        }
    }
}

/// Whether [`write_atomically`] could write `path` now, to be asked before long work. Changes nothing.
///
/// # Errors
/// Those of [`write_atomically`].
pub fn check_writable(path: &Path) -> io::Result<()> {
    match Target::of(path)? {
        Target::InPlace(_) => Ok(()),
        // Where the system can, a file without a name, which nothing leaves behind.
        Target::Replace(path) => {
            let folder = existing_folder_of(&path)?;
            tempfile::tempfile_in(folder).map(drop).map_err(|error| cannot_write(folder, &error))
        }
    }
}

/// Removes from the folder of `path` the temporary files of programs that were killed while they wrote. Those that a program
/// has open stay; what cannot be looked at or removed does no harm and stays too.
pub fn remove_abandoned(path: &Path) {
    let Ok(Target::Replace(path)) = Target::of(path) else { return };
    for entry in fs::read_dir(folder_of(&path)).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let is_ours = name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX));
        if is_ours
            && let Ok(file) = File::open(entry.path())
            && file.try_lock().is_ok()
        {
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// The temporary files that this program has not finished.
static UNFINISHED: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn unfinished() -> MutexGuard<'static, Vec<PathBuf>> {
    UNFINISHED.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A program takes the signals here that would end it in the middle of a file. Called before it begins one.
static BEFORE_WRITING: OnceLock<fn()> = OnceLock::new();

/// Has `prepare` called before each file is begun, in the thread that begins it. A program has one such function: the
/// first that is given.
pub fn before_writing(prepare: fn()) {
    let _ = BEFORE_WRITING.set(prepare);
}

/// Removes the temporary files of this program, which is about to end by a signal. From then on it makes none: whoever begins a
/// file, or ends one, waits for ever.
pub fn remove_unfinished() {
    let files = unfinished();
    for file in &*files {
        // What is gone by itself does no harm.
        let _ = fs::remove_file(file);
    }
    mem::forget(files);
}

/// A temporary file, known to [`remove_unfinished`] and removed when dropped.
#[derive(Debug)]
struct Temporary(Option<NamedTempFile>);

impl Temporary {
    fn as_file(&self) -> io::Result<&File> {
        self.0.as_ref().map(NamedTempFile::as_file).ok_or_else(|| io::Error::other("the file is finished"))
    }

    fn is_there(&self) -> bool {
        self.0.as_ref().is_some_and(|file| file.path().exists())
    }

    /// Gives the file its name.
    fn persist(mut self, path: &Path) -> io::Result<()> {
        let Some(file) = self.0.take() else { return Ok(()) };
        let mut all = unfinished();
        forget(&mut all, file.path());
        file.persist(path).map(drop).map_err(|failed| failed.error)
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Some(file) = self.0.take() {
            // The list is locked until the file is deleted. A signal in between would find no name and leave the file.
            let mut all = unfinished();
            forget(&mut all, file.path());
            drop(file);
        }
    }
}

fn forget(all: &mut Vec<PathBuf>, path: &Path) {
    all.retain(|known| known != path);
}

/// How a path is written.
enum Target {
    /// A pipe or a device.
    InPlace(PathBuf),
    /// A file, new or old, all links followed.
    Replace(PathBuf),
}

impl Target {
    fn of(path: &Path) -> io::Result<Self> {
        match path.metadata() {
            Ok(found) if found.is_dir() => {
                Err(io::Error::new(io::ErrorKind::IsADirectory, "this is a folder; give the name of a file"))
            }
            Ok(found) if found.is_file() => path.canonicalize().map(Self::Replace),
            Ok(_) => Ok(Self::InPlace(path.to_owned())),
            Err(_) if path.file_name().is_none() || path.to_string_lossy().ends_with(std::path::is_separator) => {
                let message = "this is the name of a folder; give the name of a file";
                Err(io::Error::new(io::ErrorKind::InvalidInput, message))
            }
            Err(error) => match path.read_link() {
                // A link to what is not there yet is followed like any other. One in a circle is replaced.
                Ok(target) if error.kind() == io::ErrorKind::NotFound => Self::of(&folder_of(path).join(target)),
                _ => Ok(Self::Replace(path.to_owned())),
            },
        }
    }
}

/// What the names of temporary files begin and end with.
const PREFIX: &str = ".lobe-";
const SUFFIX: &str = ".tmp";

fn folder_of(path: &Path) -> &Path {
    match path.parent() {
        Some(folder) if folder != Path::new("") => folder,
        _ => Path::new("."),
    }
}

/// The folder of `path`, if there is one.
fn existing_folder_of(path: &Path) -> io::Result<&Path> {
    let folder = folder_of(path);
    if folder.is_dir() {
        return Ok(folder);
    }
    let message = format!("the folder {} does not exist; make it first", folder.display());
    Err(io::Error::new(io::ErrorKind::NotFound, message))
}

fn cannot_write(folder: &Path, error: &io::Error) -> io::Error {
    let message = format!("cannot write into the folder {}: {}", folder.display(), error.kind());
    io::Error::new(error.kind(), message)
}

/// A new temporary file in the folder of `path`, removed when dropped.
///
/// It is locked as long as it is open, which ends with the program, however that ends: one that can be locked is abandoned.
fn temporary_beside(path: &Path) -> io::Result<Temporary> {
    let folder = existing_folder_of(path)?;
    let mut builder = Builder::new();
    builder.prefix(PREFIX).suffix(SUFFIX);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        // The user's umask takes away what is to be taken away.
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    loop {
        let mut all = unfinished();
        let temporary = builder.tempfile_in(folder).map_err(|error| cannot_write(folder, &error))?;
        all.push(temporary.path().to_path_buf());
        drop(all);
        let temporary = Temporary(Some(temporary));
        // Where the system has no locks, nobody else can lock it either, and it is not taken for abandoned.
        let is_locked = temporary.as_file()?.lock().is_ok();
        // Between its making and its locking another program may have taken it for abandoned.
        if !is_locked || temporary.is_there() {
            return Ok(temporary);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let mut names: Vec<_> =
            fs::read_dir(folder).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_file_is_written_and_nothing_else_is_left() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        for text in ["first", "second"] {
            write_atomically(&path, |w| w.write_all(text.as_bytes())).unwrap();
            assert_eq!(fs::read_to_string(&path).unwrap(), text, "content");
        }
        assert_eq!(names(folder.path()), ["a.txt"], "files in the folder");
    }

    #[test]
    fn a_failing_writer_leaves_the_old_file() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        fs::write(&path, "old").unwrap();
        let result = write_atomically(&path, |w| {
            w.write_all(b"half")?;
            Err(io::Error::other("the writer fails"))
        });
        assert_eq!(result.unwrap_err().to_string(), "the writer fails", "error");
        assert_eq!(fs::read_to_string(&path).unwrap(), "old", "content");
        assert_eq!(names(folder.path()), ["a.txt"], "files in the folder");
    }

    #[test]
    fn a_staged_file_has_no_name_until_it_is_published() {
        let folder = tempfile::tempdir().unwrap();
        let paths = ["a.txt", "b.txt"].map(|name| folder.path().join(name));
        let staged = paths.each_ref().map(|path| StagedFile::write(path, |w| w.write_all(b"new")).unwrap());
        assert!(names(folder.path()).iter().all(|name| name.starts_with(".lobe-")), "{:?}", names(folder.path()));
        let [a, b] = staged;
        a.publish().unwrap();
        drop(b);
        assert_eq!(names(folder.path()), ["a.txt"], "published, and dropped");
    }

    #[test]
    fn folders_that_are_missing_or_meant_as_files_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("file"), "").unwrap();
        for (path, part) in [
            ("none/a.txt", "does not exist"),
            ("file/a.txt", "does not exist"),
            ("", "is a folder"),
            ("none/", "name of a folder"),
        ] {
            let path = folder.path().join(path);
            for error in [check_writable(&path), write_atomically(&path, |_| Ok(()))].map(Result::unwrap_err) {
                assert!(error.to_string().contains(part), "{}: {error}", path.display());
            }
        }
    }

    #[test]
    fn checking_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        check_writable(&folder.path().join("a.txt")).unwrap();
        assert_eq!(names(folder.path()), [""; 0], "files in the folder");
    }

    #[test]
    fn what_was_abandoned_is_removed_when_asked_for_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let abandoned = folder.path().join(".lobe-abcdef.tmp");
        fs::write(&abandoned, "half").unwrap();
        fs::write(folder.path().join(".lobe-notes"), "kept").unwrap();
        let path = folder.path().join("a.txt");
        write_atomically(&path, |w| {
            check_writable(&folder.path().join("b.txt"))?;
            assert!(abandoned.exists(), "a check removes nothing");
            remove_abandoned(&folder.path().join("b.txt"));
            assert!(!abandoned.exists(), "the file of nobody is removed");
            assert_eq!(names(folder.path()).len(), 2, "that which is being written stays");
            w.write_all(b"whole")
        })
        .unwrap();
        assert_eq!(names(folder.path()), [".lobe-notes", "a.txt"], "files in the folder");
    }

    #[test]
    fn at_no_moment_is_a_temporary_file_there_that_a_signal_would_leave() {
        const FILES: usize = 2000;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.txt");
        let maker = std::thread::spawn(move || (0..FILES).for_each(|_| drop(StagedWriter::new(&path).unwrap())));
        let mut looks = 0;
        while !maker.is_finished() || looks == 0 {
            // A signal would hold the list like this.
            let all = unfinished();
            for name in names(folder.path()) {
                let is_known = all.iter().any(|known| known.file_name().is_some_and(|known| known == &*name));
                assert!(is_known, "{name} is there and would stay");
            }
            looks += 1;
        }
        maker.join().unwrap();
        assert_eq!(names(folder.path()), [""; 0], "files in the folder after {looks} looks");
    }

    #[cfg(unix)]
    #[test]
    fn permissions_links_and_devices_are_respected() {
        use std::os::unix::fs::{FileTypeExt as _, PermissionsExt as _};

        let folder = tempfile::tempdir().unwrap();
        let [plain, fresh, link] = ["plain", "fresh", "link"].map(|name| folder.path().join(name));
        fs::write(&plain, "").unwrap();
        write_atomically(&fresh, |w| w.write_all(b"x")).unwrap();
        let mode = |path: &Path| path.metadata().unwrap().permissions().mode();
        assert_eq!(mode(&fresh), mode(&plain), "a new file has the usual permissions");

        fs::set_permissions(&plain, fs::Permissions::from_mode(0o640)).unwrap();
        std::os::unix::fs::symlink(&plain, &link).unwrap();
        write_atomically(&link, |w| w.write_all(b"through")).unwrap();
        assert_eq!(fs::read_to_string(&plain).unwrap(), "through", "the link's file");
        assert!(link.is_symlink(), "the link is still a link");
        assert_eq!(mode(&plain) & 0o777, 0o640, "a replaced file keeps its permissions");

        let [missing, dangling, circle] = ["missing", "dangling", "circle"].map(|name| folder.path().join(name));
        std::os::unix::fs::symlink("missing", &dangling).unwrap();
        std::os::unix::fs::symlink("circle", &circle).unwrap();
        for link in [&dangling, &dangling, &circle] {
            write_atomically(link, |w| w.write_all(b"followed")).unwrap();
        }
        assert_eq!(fs::read_to_string(&missing).unwrap(), "followed", "what a dangling link names");
        assert_eq!((dangling.is_symlink(), circle.is_symlink()), (true, false), "links, and one that names itself");

        let null = Path::new("/dev/null");
        write_atomically(null, |w| w.write_all(b"gone")).unwrap();
        assert!(null.metadata().unwrap().file_type().is_char_device(), "the null device is still a device");
    }
}
