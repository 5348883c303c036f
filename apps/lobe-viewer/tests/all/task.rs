//! Work beside the window.

use std::ops::ControlFlow;
use std::time::Duration;

use lobe::io::Progress;
use lobe_viewer::{Task, TaskEvent};

/// All events of a task until it ends.
fn all<T: Send + 'static>(task: &Task<T>) -> Vec<TaskEvent<T>> {
    let mut events = Vec::new();
    while !matches!(events.last(), Some(TaskEvent::Done | TaskEvent::Cancelled | TaskEvent::Failed(_))) {
        events.extend(task.events());
        std::thread::sleep(Duration::from_millis(1));
    }
    events
}

#[test]
fn work_that_is_cancelled_ends_at_its_next_report() {
    let task = Task::start(
        "forever",
        || (),
        |control| {
            control.stage("counting");
            let mut watch = control.watch();
            let mut done = 0;
            while watch(&Progress { done, total: 10, ..Progress::default() }) == ControlFlow::Continue(()) {
                done = (done + 1) % 10;
                if done == 5 {
                    control.send(());
                }
            }
            Ok(())
        },
    );
    while task.events().is_empty() {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(task.progress().is_some_and(|part| (0.0..1.0).contains(&part)), "{:?}", task.progress());
    task.cancel();
    assert_eq!(all(&task).last(), Some(&TaskEvent::Cancelled), "the last event");
}

#[test]
fn a_task_is_at_work_from_its_first_stage_until_it_rests() {
    let (go, wait) = std::sync::mpsc::channel::<()>();
    let task = Task::start(
        "player",
        || (),
        move |control| {
            control.stage("reading");
            control.send(1);
            let _ = wait.recv();
            control.rest();
            Ok(())
        },
    );
    while task.events().is_empty() {
        std::thread::sleep(Duration::from_millis(1));
    }
    assert!(task.is_at_work() && task.progress().is_none(), "{}", task.describe());
    go.send(()).unwrap();
    assert_eq!(all(&task), [TaskEvent::Done], "the end");
    assert!(!task.is_at_work(), "{}", task.describe());
}

#[test]
fn a_panic_of_the_work_is_a_failure_in_one_line() {
    let task: Task<()> = Task::start(
        "broken",
        || (),
        |control| {
            control.stage("reading");
            let numbers: Vec<usize> = Vec::new();
            control.send(());
            assert!(!numbers.is_empty(), "no numbers");
            Ok(())
        },
    );
    let events = all(&task);
    assert_eq!(task.describe(), "broken: reading", "its stage");
    assert_eq!(events[0], TaskEvent::Result(()), "what came before");
    assert!(matches!(&events[1], TaskEvent::Failed(line) if line.contains("fault of this program")), "{events:?}");
}

#[test]
fn work_that_waits_goes_on_when_it_is_released_before_or_after_it_waits_and_when_it_is_cancelled() {
    type Act = fn(&Task<u8>);
    let ways: [(Act, &[TaskEvent<u8>]); 2] =
        [(Task::release, &[TaskEvent::Result(2), TaskEvent::Done]), (Task::cancel, &[TaskEvent::Cancelled])];
    for (act, expected) in ways {
        for is_early in [false, true] {
            let (go, begin) = std::sync::mpsc::channel::<()>();
            let task = Task::start(
                "baker",
                || (),
                move |control| {
                    begin.recv().map_err(|error| error.to_string())?;
                    control.send(1);
                    control.wait(Duration::from_secs(600));
                    if !control.is_cancelled() {
                        control.send(2);
                    }
                    Ok(())
                },
            );
            if is_early {
                act(&task);
            }
            go.send(()).unwrap();
            let mut events = Vec::new();
            while events.is_empty() {
                std::thread::sleep(Duration::from_millis(1));
                events = task.events();
            }
            assert_eq!(events.remove(0), TaskEvent::Result(1), "what it had before it waited");
            if !is_early {
                assert_eq!((events.len(), task.events().len()), (0, 0), "it waits");
                act(&task);
            }
            if !matches!(events.last(), Some(TaskEvent::Done | TaskEvent::Cancelled)) {
                events.extend(all(&task));
            }
            assert_eq!(events, expected, "early: {is_early}");
        }
    }
}

#[test]
fn work_that_is_finished_hands_out_all_that_is_left() {
    let task = Task::start(
        "count",
        || (),
        |control| {
            (0..3).for_each(|k| control.send(k));
            std::thread::sleep(Duration::from_millis(20));
            Err("no more".into())
        },
    );
    let mut events = task.events();
    events.extend(task.finish());
    let results = (0..3).map(TaskEvent::Result);
    assert_eq!(events, results.chain([TaskEvent::Failed("no more".into())]).collect::<Vec<_>>(), "all, once");
    assert!(task.finish().is_empty(), "and no more");
}

#[test]
fn work_waits_no_longer_than_it_says() {
    let task = Task::start(
        "hidden",
        || (),
        |control| {
            control.wait(Duration::from_millis(20));
            control.send(());
            Ok(())
        },
    );
    assert_eq!(all(&task), [TaskEvent::Result(()), TaskEvent::Done]);
}
