//! Chromium, driven over pipes by the protocol of its developer tools.
//!
//! <https://chromedevtools.github.io/devtools-protocol/>: JSON messages, each ended by a zero byte,
//! go in through descriptor 3 and come out of descriptor 4.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;

use serde_json::{Value, json};
use tempfile::TempDir;

/// The names under which the browser is installed.
const NAMES: [&str; 3] = ["chromium", "chromium-browser", "google-chrome"];

/// The time after which a browser that says nothing has failed. A loaded machine is slow.
const PATIENCE: Duration = Duration::from_secs(120);

/// A browser with one tab.
pub(crate) struct Browser {
    process: Child,
    input: ChildStdin,
    messages: Receiver<Value>,
    session: String,
    last: u64,
    /// The events that have come since the last [`Browser::open`].
    pub(crate) events: Vec<Value>,
    /// The directory of everything that the browser writes.
    _profile: TempDir,
}

impl Browser {
    /// Starts the browser; `None` if there is none on this machine.
    pub(crate) fn start() -> Option<Self> {
        let is_there = |name: &&&str| {
            Command::new(name)
                .arg("--version")
                .stdout(Stdio::null())
                .stderr(Stdio::null())
                .status()
                .is_ok_and(|status| status.success())
        };
        let name = NAMES.iter().find(is_there)?;
        let profile = TempDir::new().unwrap();
        let mut command = Command::new("sh");
        // The shell moves the pipes to the descriptors that the protocol has.
        command.args(["-c", "exec \"$@\" 3<&0 4>&1 </dev/null >/dev/null 2>&1", "sh", name]);
        command.args(["--headless", "--remote-debugging-pipe", "--disable-gpu"]);
        command.args(["--disable-dev-shm-usage", "--no-first-run", "--disable-extensions"]);
        command.args(["--disable-background-networking", "--disable-component-update"]);
        command.arg(format!("--user-data-dir={}", profile.path().display()));
        if rustix::process::geteuid().is_root() {
            // The sandbox refuses root.
            command.arg("--no-sandbox");
        }
        command.env("HOME", profile.path()).env("TMPDIR", profile.path());
        command.env_remove("XDG_CONFIG_HOME").env_remove("XDG_CACHE_HOME");
        let mut process =
            command.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("sh starts");
        let input = process.stdin.take().unwrap();
        let mut output = BufReader::new(process.stdout.take().unwrap());
        let (sender, messages) = channel();
        std::thread::spawn(move || {
            let mut bytes = Vec::new();
            while output.read_until(0, &mut bytes).is_ok_and(|count| count > 0) {
                bytes.pop();
                let Ok(message) = serde_json::from_slice(&bytes) else { return };
                if sender.send(message).is_err() {
                    return;
                }
                bytes.clear();
            }
        });
        let mut browser = Self {
            process,
            input,
            messages,
            session: String::new(),
            last: 0,
            events: Vec::new(),
            _profile: profile,
        };
        let tab = browser.call("Target.createTarget", json!({ "url": "about:blank" }));
        let tab = json!({ "targetId": tab["targetId"], "flatten": true });
        let session = browser.call("Target.attachToTarget", tab);
        browser.session = session["sessionId"].as_str().unwrap().to_owned();
        for domain in ["Page", "Runtime", "Log", "Network"] {
            browser.call(&format!("{domain}.enable"), json!({}));
        }
        Some(browser)
    }

    fn next(&mut self) -> Value {
        self.messages.recv_timeout(PATIENCE).expect("the browser answers")
    }

    /// Calls a method of the protocol and returns its result.
    pub(crate) fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.last += 1;
        let id = self.last;
        let mut message = json!({ "id": id, "method": method, "params": parameters });
        if !self.session.is_empty() {
            message["sessionId"] = json!(self.session);
        }
        let mut bytes = serde_json::to_vec(&message).unwrap();
        bytes.push(0);
        self.input.write_all(&bytes).unwrap();
        loop {
            let mut answer = self.next();
            if answer["id"] != id {
                self.events.push(answer);
                continue;
            }
            assert!(answer.get("error").is_none(), "{method}: {}", answer["error"]);
            return answer["result"].take();
        }
    }

    /// Opens an address and waits until it is loaded.
    pub(crate) fn open(&mut self, address: &str) {
        self.events.clear();
        self.call("Page.navigate", json!({ "url": address }));
        let is_loaded = |event: &Value| event["method"] == "Page.loadEventFired";
        while !self.events.iter().any(is_loaded) {
            let event = self.next();
            self.events.push(event);
        }
    }

    /// Evaluates an expression in the page.
    pub(crate) fn value(&mut self, expression: &str) -> Value {
        let parameters =
            json!({ "expression": expression, "returnByValue": true, "awaitPromise": true });
        let mut answer = self.call("Runtime.evaluate", parameters);
        assert!(answer.get("exceptionDetails").is_none(), "{expression}: {answer}");
        answer["result"]["value"].take()
    }

    /// Sends an event of the mouse to a place in the window.
    fn mouse(&mut self, kind: &str, [x, y]: [f64; 2]) {
        let pressed = u8::from(kind != "mouseMoved");
        let button = if pressed == 1 { "left" } else { "none" };
        let event =
            json!({ "type": kind, "x": x, "y": y, "button": button, "clickCount": pressed });
        self.call("Input.dispatchMouseEvent", event);
    }

    /// Returns the middle of the element that an expression gives, after scrolling to it.
    fn middle(&mut self, element: &str) -> [f64; 2] {
        let place = self.value(&format!(
            "(() => {{ const e = {element}; e.scrollIntoView({{ block: 'center' }}); \
             const r = e.getBoundingClientRect(); \
             return [r.left + r.width / 2, r.top + r.height / 2]; }})()"
        ));
        serde_json::from_value(place).unwrap_or_else(|_| panic!("{element} has a place"))
    }

    /// Moves the pointer over the element that an expression gives.
    pub(crate) fn point_at(&mut self, element: &str) {
        let middle = self.middle(element);
        self.mouse("mouseMoved", middle);
    }

    /// Clicks on the element that an expression gives.
    pub(crate) fn click(&mut self, element: &str) {
        let middle = self.middle(element);
        for kind in ["mouseMoved", "mousePressed", "mouseReleased"] {
            self.mouse(kind, middle);
        }
    }

    /// Taps with a finger on the element that an expression gives.
    pub(crate) fn tap(&mut self, element: &str) {
        let [x, y] = self.middle(element);
        let touch = |kind: &str, points: Value| json!({ "type": kind, "touchPoints": points });
        self.call("Input.dispatchTouchEvent", touch("touchStart", json!([{ "x": x, "y": y }])));
        self.call("Input.dispatchTouchEvent", touch("touchEnd", json!([])));
    }

    /// Presses a key.
    pub(crate) fn press(&mut self, key: &str) {
        for kind in ["keyDown", "keyUp"] {
            self.call("Input.dispatchKeyEvent", json!({ "type": kind, "key": key }));
        }
    }

    /// Returns everything that was requested since the last [`Browser::open`].
    pub(crate) fn requests(&self) -> Vec<&str> {
        let address = |event: &Value| event["method"] == "Network.requestWillBeSent";
        let requested = self.events.iter().filter(|event| address(event));
        requested.map(|event| event["params"]["request"]["url"].as_str().unwrap_or("")).collect()
    }

    /// Returns everything that the page has complained of since the last [`Browser::open`].
    pub(crate) fn complaints(&self) -> Vec<&Value> {
        let is_complaint = |event: &&Value| {
            ["Runtime.exceptionThrown", "Runtime.consoleAPICalled", "Log.entryAdded"]
                .iter()
                .any(|method| event["method"] == *method)
        };
        self.events.iter().filter(is_complaint).collect()
    }
}

impl Drop for Browser {
    fn drop(&mut self) {
        let close = "{\"id\":0,\"method\":\"Browser.close\"}\0";
        let is_told = self.input.write_all(close.as_bytes()).is_ok();
        // The pipe closes when the browser has ended.
        let deadline = std::time::Instant::now() + Duration::from_secs(30);
        while is_told && std::time::Instant::now() < deadline {
            match self.messages.recv_timeout(Duration::from_secs(1)) {
                Err(std::sync::mpsc::RecvTimeoutError::Disconnected) => break,
                Err(std::sync::mpsc::RecvTimeoutError::Timeout) | Ok(_) => {}
            }
        }
        if !matches!(self.process.try_wait(), Ok(Some(_))) {
            std::thread::sleep(Duration::from_millis(200));
            let _ = self.process.kill();
        }
        let _ = self.process.wait();
    }
}
