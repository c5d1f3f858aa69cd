//! The steps of a probe that start a process for each request.

use std::collections::BTreeMap;

use ptm::Format;
use ptm_suite::protocol::frame::{Answer, View};
use ptm_suite::protocol::request::Reply;

use super::calls::Calls;
use super::checklist::{Checklist, Reproduction};
use super::explain::{explain, refusal_fault};
use super::message::{Slots, fault};
use super::{repair::repair, sample::Sample};

/// The formats that most readers support, which are requested first. The other formats are requested in the order of the
/// specification.
const COMMON_FORMATS: [Format; 4] = [Format::Lrgb, Format::Rgb, Format::PtmCLut, Format::PtmLut];

/// A file, and the decoder's reply in each view.
pub(super) struct FileReplies {
    pub(super) sample: Sample,
    pub(super) replies: Vec<(View, Reply)>,
}

impl FileReplies {
    fn new(calls: &Calls, sample: Sample) -> FileReplies {
        let views = ["raw", "coef", View::DEFAULT_RGB];
        let views = views.map(|view| view.parse().expect("a view")).into_iter();
        let mut replies = Vec::new();
        for view in views {
            let reply = calls.ask(&view, &sample.file);
            let timed_out = matches!(reply.answer, Answer::TimedOut(_));
            replies.push((view, reply));
            // The other views would probably take too long as well.
            if timed_out {
                break;
            }
        }
        FileReplies { sample, replies }
    }

    fn request_in_best_spelling(calls: &Calls, format: Format) -> FileReplies {
        let mut samples = Sample::samples_in_all_spellings(format);
        let first = samples.next().expect("every format has a spelling");
        let mut best = FileReplies::new(calls, first);
        let unsupported = |(_, reply): &(View, Reply)| reply.answer == Answer::Unsupported;
        while !best.rank()[2] && !best.replies.iter().all(unsupported) && !best.has_timeout() {
            let Some(sample) = samples.next() else { break };
            let asked = FileReplies::new(calls, sample);
            if asked.rank() > best.rank() {
                best = asked;
            }
        }
        best
    }

    /// Rates the best reply with three flags: whether it is a frame, has the right size, and has the correct samples.
    fn rank(&self) -> [bool; 3] {
        let one = |(view, reply): &(View, Reply)| match &reply.answer {
            Answer::Decoded(frame) => {
                let is_right = self.sample.expected(view).compare(frame).is_none();
                [true, self.sample.has_size(frame), is_right]
            }
            _ => [false; 3],
        };
        self.replies.iter().map(one).max().unwrap_or_default()
    }

    /// Returns true if the decoder exceeded the time limit in at least one view.
    fn has_timeout(&self) -> bool {
        let timed_out = |(_, reply): &(View, Reply)| matches!(reply.answer, Answer::TimedOut(_));
        self.replies.iter().any(timed_out)
    }

    /// Returns true if every view is decoded correctly or not supported.
    fn is_faultless(&self) -> bool {
        let is_faultless = |(view, reply): &(View, Reply)| match &reply.answer {
            Answer::Decoded(frame) => self.sample.expected(view).compare(frame).is_none(),
            answer => *answer == Answer::Unsupported,
        };
        self.replies.iter().all(is_faultless)
    }

    /// Returns true if requesting more files is pointless.
    fn ends_search(&self) -> bool {
        let is_final = |(_, reply): &(View, Reply)| match reply.answer {
            Answer::NotStarted(_) | Answer::NotAsked(_) => true,
            _ => reply.stdout.windows(5).any(|bytes| bytes == b"PTM1 "),
        };
        self.has_timeout() || self.replies.iter().any(is_final)
    }
}

/// Finds a format that the decoder reads, and judges the images of a file in that format. Returns the replies that are frames.
pub(super) fn find_first_frames(calls: &Calls, list: &mut Checklist) -> Option<FileReplies> {
    let (mut troubled, mut unsupported) = (None, None);
    let others = Format::ALL.into_iter();
    let others = others.filter(|format| !COMMON_FORMATS.contains(format));
    for format in COMMON_FORMATS.into_iter().chain(others) {
        let mut asked = FileReplies::request_in_best_spelling(calls, format);
        if asked.rank()[0] {
            judge_views(&asked, list);
            let is_frame = |reply: &Reply| matches!(reply.answer, Answer::Decoded(_));
            asked.replies.retain(|(_, reply)| is_frame(reply));
            return Some(asked);
        }
        let ends_search = asked.ends_search();
        match (asked.replies.iter()).position(|(_, reply)| reply.answer != Answer::Unsupported) {
            Some(first) => {
                asked.replies.drain(..first);
                troubled = troubled.or(Some(asked));
            }
            None => unsupported = unsupported.or(Some(asked)),
        }
        if ends_search {
            break;
        }
    }
    let FileReplies { sample, replies } = troubled.or(unsupported)?;
    let (view, reply) = &replies[0];
    let known = calls.explain_no_frame(&sample.file, &sample.expected(view), view, reply);
    if known.is_none() && reply.answer == Answer::Unsupported {
        let (says, next) = fault("nothing-supported", &[]);
        list.add_bad(says, next);
        return None;
    }
    let subject = format!("{} {view}", sample.format.short_name());
    let fault = known.unwrap_or_else(|| explain(reply));
    list.add_fault(&subject, fault, sample.reproduction(view));
    None
}

/// Requests a file in each of the other formats. For each file, the decoder must return an image or exit with 69.
pub(super) fn request_other_formats(calls: &Calls, first: &FileReplies, list: &mut Checklist) {
    let mut unsupported = Vec::new();
    let mut failed: BTreeMap<String, (Vec<&str>, Reproduction)> = BTreeMap::new();
    let is_other = |format: &Format| *format != first.sample.format;
    for format in Format::ALL.into_iter().filter(is_other) {
        let asked = FileReplies::request_in_best_spelling(calls, format);
        let name = format.short_name();
        let is_supported = |(_, reply): &&(View, Reply)| reply.answer != Answer::Unsupported;
        match asked.replies.iter().find(is_supported) {
            None => unsupported.push(name),
            Some(_) if asked.is_faultless() => {
                list.add_good(format!(
                    "{name}: decoded correctly{}",
                    asked.sample.spelling_text()
                ));
            }
            Some(_) if asked.rank()[0] => judge_views(&asked, list),
            Some((view, reply)) => {
                let reproduction = || (Vec::new(), asked.sample.reproduction(view));
                let same = failed
                    .entry(reply.answer.describe())
                    .or_insert_with(reproduction);
                same.0.push(name);
            }
        }
        if asked.has_timeout() {
            break;
        }
    }
    if !unsupported.is_empty() {
        list.add_absent(format!("not supported: {}", unsupported.join(", ")));
    }
    for (answer, (names, reproduction)) in failed {
        let fault = fault("format-not-read", &[("answer", &answer)]);
        list.add_fault(&names.join(", "), fault, reproduction);
    }
}

/// Reports the result of each view of a file. For a wrong image, describes how to repair it.
fn judge_views(FileReplies { sample, replies }: &FileReplies, list: &mut Checklist) {
    let name = sample.format.short_name();
    if sample.format.has_table() {
        list.add_good(format!("{name}: decoded{}", sample.spelling_text()));
    }
    for (view, reply) in replies {
        let subject = format!("{name} {view}");
        let expected = sample.expected(view);
        let wrong = match &reply.answer {
            Answer::Decoded(frame) => match expected.compare(frame) {
                None => {
                    list.add_good(format!("{subject}: decoded correctly"));
                    continue;
                }
                Some(difference) => {
                    let name = if frame.view != view.kind() {
                        "view-ignored"
                    } else if frame.channels as usize != expected.channels {
                        "other-channels"
                    } else {
                        "wrong-image"
                    };
                    fault(name, &[("difference", &difference)])
                }
            },
            Answer::Unsupported => {
                let says = "exited with 69: this view is not offered, which is allowed";
                list.add_absent(format!("{subject}: {says}"));
                continue;
            }
            answer => fault("no-image", &[("answer", &answer.describe())]),
        };
        let fault = repair(&reply.stdout, &expected, view).unwrap_or(wrong);
        list.add_fault(&subject, fault, sample.reproduction(view));
    }
}

/// Requests a frame that is larger than the buffer of a pipe.
pub(super) fn request_large_frame(calls: &Calls, first: &FileReplies, list: &mut Checklist) {
    let sample = Sample::large(first.sample.format, first.sample.spelling);
    for (view, _) in &first.replies {
        let reply = calls.ask(view, &sample.file);
        let subject = sample.size_text(view);
        let fault = match &reply.answer {
            Answer::Decoded(frame) if sample.has_size(frame) => {
                list.add_good(format!("{subject}: complete"));
                continue;
            }
            Answer::Decoded(frame) => {
                let (width, height, size) = (frame.width, frame.height, sample.size);
                let slots: &Slots = &[("width", &width), ("height", &height), ("size", &size)];
                fault("large-size", slots)
            }
            _ => explain(&reply),
        };
        list.add_fault(&subject, fault, sample.reproduction(view));
    }
}

/// Requests files that every decoder must refuse.
pub(super) fn request_malformed_files(calls: &Calls, first: &FileReplies, list: &mut Checklist) {
    let view = &first.replies[0].0;
    for (subject, file_name, file) in malformed(&first.sample.file) {
        let reply = calls.ask(view, file);
        if reply.answer == Answer::Rejected {
            list.add_good(format!("{subject}: refused with 65"));
            continue;
        }
        let reproduction = Reproduction::one_shot(view, file_name, file);
        list.add_fault(&subject, refusal_fault(&reply), reproduction);
    }
}

/// Returns files that every decoder must refuse: a description, a name, and the bytes of each.
pub(super) fn malformed(whole: &[u8]) -> [(&'static str, &'static str, &[u8]); 3] {
    let no_ptm = b"\x89PNG\r\n\x1a\nneither a PNG nor a PTM";
    let cut_short = &whole[..whole.len() - 7];
    [
        ("an empty file", "empty.ptm", b""),
        ("a file that is not a PTM", "no.ptm", no_ptm),
        ("a PTM that ends too soon", "cut-short.ptm", cut_short),
    ]
}

pub(super) fn request_unknown_view(calls: &Calls, sample: &Sample, list: &mut Checklist) {
    const UNKNOWN_VIEW: &str = "no-such-view";
    let reply = calls.call_with_word(UNKNOWN_VIEW, &["{in}"], &sample.file);
    let fault = match &reply.answer {
        Answer::Unsupported => return list.add_good("an unknown view: exited with 69"),
        Answer::Decoded(_) => fault("unknown-view-shown", &[]),
        answer => fault("unknown-view", &[("answer", &answer.describe())]),
    };
    list.add_fault(
        &"an unknown view",
        fault,
        sample.reproduction(&UNKNOWN_VIEW),
    );
}

pub(super) fn request_capabilities(calls: &Calls, list: &mut Checklist) {
    let reply = calls.call_with_word("capabilities", &[], b"");
    let text = String::from_utf8_lossy(&reply.stdout);
    let says_so = text.lines().any(|line| line.trim_end() == "protocol: 1");
    if reply.exit == Some(0) && says_so {
        list.add_good("capabilities: declared");
    } else {
        list.add_absent("capabilities: not declared (optional)");
    }
}
