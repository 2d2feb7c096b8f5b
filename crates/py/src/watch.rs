//! Long calls: on a thread of their own, with the GIL released; the caller's
//! thread reports progress and takes cancellation.

use std::panic::{catch_unwind, AssertUnwindSafe};
use std::sync::mpsc::{channel, RecvTimeoutError};
use std::sync::Arc;
use std::time::Duration;

use assetpipe_decompose::control::Control;
use pyo3::prelude::*;

use crate::errors::{cancelled_error, engine_error};

/// Between two looks at the caller.
const PAUSE: Duration = Duration::from_millis(30);
/// So many pauses are waited for work that was asked to stop. Then it is left to itself: it ends
/// at its next look at the flag, and nobody hears of it.
const FAREWELL: u32 = 1;

/// Run `work`; call `on_progress(share)` now and then. A return of `False`, an
/// exception or a signal stops the work, and this returns within a tenth of a second whatever
/// the work is at. A panic is an `EngineError`.
pub fn run<T: Send + 'static>(
    py: Python<'_>,
    on_progress: Option<&Bound<'_, PyAny>>,
    work: impl FnOnce(&Control) -> T + Send + 'static,
) -> PyResult<T> {
    let control = Arc::new(Control::default());
    let (send, mut receive) = channel();
    let mut stopped: Option<PyErr> = None;
    let shared = Arc::clone(&control);
    let worker = std::thread::Builder::new()
        .stack_size(64 << 20)
        .spawn(move || {
            let outcome = catch_unwind(AssertUnwindSafe(|| work(&shared)));
            // Nobody may be there any more to receive it.
            let _ = send.send(outcome);
        });
    if let Err(error) = worker {
        return Err(engine_error(
            py,
            &format!("no thread could be started: {error}"),
        ));
    }
    let mut waited = 0;
    let outcome = loop {
        // A channel's end is not Sync; the wait owns it and gives it back.
        let (answer, back) = py.detach(move || (receive.recv_timeout(PAUSE), receive));
        receive = back;
        match answer {
            Ok(outcome) => break outcome,
            Err(RecvTimeoutError::Disconnected) => {
                return Err(engine_error(
                    py,
                    "the engine's thread ended without a result",
                ));
            }
            Err(RecvTimeoutError::Timeout) if !control.is_cancelled() => {
                let asked = py.check_signals().and_then(|()| ask(on_progress, &control));
                match asked {
                    Ok(true) => {}
                    Ok(false) => control.cancel(),
                    Err(error) => {
                        control.cancel();
                        stopped = Some(error);
                    }
                }
            }
            Err(RecvTimeoutError::Timeout) if waited < FAREWELL => waited += 1,
            Err(RecvTimeoutError::Timeout) => {
                return Err(stopped.unwrap_or_else(|| cancelled_error(py)));
            }
        }
    };
    // An answer that came in spite of it may be half of one.
    if control.is_cancelled() {
        return Err(stopped.unwrap_or_else(|| cancelled_error(py)));
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
