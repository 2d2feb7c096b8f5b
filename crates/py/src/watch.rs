//! Long calls: on a thread of their own, with the GIL released; the caller's
//! thread reports progress and takes cancellation.

use std::panic::{catch_unwind, AssertUnwindSafe};
use std::sync::mpsc::{channel, RecvTimeoutError};
use std::time::Duration;

use assetpipe_decompose::control::Control;
use pyo3::prelude::*;

use crate::errors::engine_error;

/// Between two looks at the caller: twice this is the time to cancel.
const PAUSE: Duration = Duration::from_millis(30);

/// Run `work`; call `on_progress(share)` now and then. A return of `False`, an
/// exception or a signal stops the work. A panic is an `EngineError`.
pub fn run<T: Send>(
    py: Python<'_>,
    on_progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Control) -> T + Send,
) -> PyResult<T> {
    let control = Control::default();
    let (send, receive) = channel();
    let mut stopped: Option<PyErr> = None;
    let outcome = std::thread::scope(|scope| {
        let control = &control;
        let worker = std::thread::Builder::new()
            .stack_size(64 << 20)
            .spawn_scoped(scope, move || {
                let outcome = catch_unwind(AssertUnwindSafe(|| work(control)));
                // The receiver outlives the scope.
                let _ = send.send(outcome);
            });
        if let Err(error) = worker {
            return Err(engine_error(
                py,
                &format!("no thread could be started: {error}"),
            ));
        }
        // A channel's end is not Sync; the wait owns it and gives it back.
        let mut receive = receive;
        loop {
            let (answer, back) = py.detach(move || (receive.recv_timeout(PAUSE), receive));
            receive = back;
            match answer {
                Ok(outcome) => return Ok(outcome),
                Err(RecvTimeoutError::Disconnected) => {
                    return Err(engine_error(
                        py,
                        "the engine's thread ended without a result",
                    ));
                }
                Err(RecvTimeoutError::Timeout) if stopped.is_none() => {
                    let asked = py.check_signals().and_then(|()| ask(on_progress, control));
                    match asked {
                        Ok(true) => {}
                        Ok(false) => control.cancel(),
                        Err(error) => {
                            control.cancel();
                            stopped = Some(error);
                        }
                    }
                }
                Err(RecvTimeoutError::Timeout) => {}
            }
        }
    })?;
    if let Some(error) = stopped {
        return Err(error);
    }
    outcome.map_err(|panic| {
        let text = panic
            .downcast_ref::<String>()
            .map(String::as_str)
            .or_else(|| panic.downcast_ref::<&str>().copied())
            .unwrap_or("unknown");
        engine_error(
            py,
            &format!("the engine failed: {text}; please report it with this mesh"),
        )
    })
}

/// Whether the caller wants to go on.
fn ask(on_progress: Option<&Bound<'_, PyAny>>, control: &Control) -> PyResult<bool> {
    let Some(callback) = on_progress else {
        return Ok(true);
    };
    let answer = callback.call1((control.progress(),))?;
    Ok(answer.is_none() || answer.is_truthy()?)
}
