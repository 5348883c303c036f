"""The lock that keeps bakes into one output apart."""

import errno
import os
import signal
import subprocess
import sys
import threading
import time

import pytest

import lobe._locked as its_module
from lobe._locked import locked

HOLDS = """
import sys, time
from lobe._locked import locked

with locked(sys.argv[1]) as is_mine:
    print(is_mine, flush=True)
    sys.stdin.read()
"""


def process_that_holds(path):
    """Another process that has the lock, or was told that it has not: the process, and what it was told."""
    process = subprocess.Popen([sys.executable, "-c", HOLDS, path], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    return process, process.stdout.readline().strip()


def end(process):
    process.stdin.close()
    assert process.wait() == 0
    process.stdout.close()


def test_of_two_in_one_program_one_has_the_lock_and_the_next_after_it(tmp_path):
    path = str(tmp_path / "o.lock")
    with locked(path) as first:
        with locked(path) as second, locked(str(tmp_path / "other.lock")) as other:
            assert (first, second, other) == (True, False, True)
        with locked(path) as third:
            assert not third, "one that was refused takes nothing away"
    assert os.listdir(tmp_path) == [], "nothing is left behind"
    with locked(path) as again:
        assert again


def test_what_is_raised_within_gives_the_lock_back(tmp_path):
    path = str(tmp_path / "o.lock")
    with pytest.raises(KeyError), locked(path):
        raise KeyError("of the work")
    with locked(path) as again:
        assert again


def test_another_process_is_kept_out_and_let_in(tmp_path):
    path = str(tmp_path / "o.lock")
    with locked(path) as mine:
        process, told = process_that_holds(path)
        assert mine and told == "False"
        end(process)
    process, told = process_that_holds(path)
    with locked(path) as mine:
        assert not mine and told == "True"
    end(process)
    with locked(path) as mine:
        assert mine


@pytest.mark.skipif(sys.platform == "win32", reason="it has no such signal")
def test_what_a_process_that_was_killed_has_left_keeps_nobody_out(tmp_path):
    path = str(tmp_path / "o.lock")
    process, told = process_that_holds(path)
    process.send_signal(signal.SIGKILL)
    process.wait()
    process.stdin.close()
    process.stdout.close()
    assert told == "True" and os.path.exists(path)
    with locked(path) as mine:
        assert mine
    assert os.listdir(tmp_path) == []


def test_many_that_take_turns_are_never_two_at_once(tmp_path):
    path, inside, most, turns = str(tmp_path / "o.lock"), [0], [0], []

    def take_turns():
        while len(turns) < 200:
            with locked(path) as mine:
                if mine:
                    inside[0] += 1
                    most[0] = max(most[0], inside[0])
                    # Others have a turn meanwhile, if they are let in.
                    time.sleep(2e-4)
                    turns.append(None)
                    inside[0] -= 1

    threads = [threading.Thread(target=take_turns) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert most == [1] and os.listdir(tmp_path) == []


@pytest.mark.parametrize("number", [errno.ENOLCK, errno.ENOTSUP])
def test_where_the_file_system_has_no_locks_nobody_is_kept_out(number, tmp_path, monkeypatch):
    def refuse(file):
        raise OSError(number, os.strerror(number))

    monkeypatch.setattr(its_module, "_take", refuse)
    with locked(str(tmp_path / "o.lock")) as mine, locked(str(tmp_path / "o.lock")) as too:
        assert mine and too
    assert os.listdir(tmp_path) == []


def test_what_the_system_refuses_otherwise_is_its_error(tmp_path, monkeypatch):
    path = str(tmp_path / "o.lock")

    def refuse(file):
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    with monkeypatch.context() as patch:
        patch.setattr(its_module, "_take", refuse)
        with pytest.raises(OSError, match=os.strerror(errno.EIO)), locked(path):
            pass
    assert os.listdir(tmp_path) == ["o.lock"], "it may be another's, and stays"
    with locked(path) as mine:
        assert mine
    assert os.listdir(tmp_path) == []


def test_a_lock_that_cannot_be_taken_away_is_given_back_without_an_error(tmp_path, monkeypatch):
    path = str(tmp_path / "o.lock")

    def refuse(path):
        raise PermissionError(errno.EPERM, os.strerror(errno.EPERM))

    with monkeypatch.context() as patch:
        patch.setattr(os, "remove", refuse)
        with locked(path) as mine:
            assert mine
    assert os.listdir(tmp_path) == ["o.lock"]
    process, told = process_that_holds(path)
    end(process)
    assert told == "True", "it keeps nobody out"


def test_a_lock_that_another_user_left_is_named_with_what_to_do(tmp_path, monkeypatch):
    path = tmp_path / "o.lock"
    path.touch()

    def refuse(*arguments):
        raise PermissionError(errno.EACCES, os.strerror(errno.EACCES))

    for has_file, said in [(True, "o.lock: left by another user; remove it"), (False, os.strerror(errno.EACCES))]:
        with monkeypatch.context() as patch:
            patch.setattr(os, "open", refuse)
            with pytest.raises(PermissionError, match=said), locked(str(path)):
                pass
        if has_file:
            path.unlink()
