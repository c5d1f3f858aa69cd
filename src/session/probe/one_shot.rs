//! The steps of a probe that start a process for each request.

use crate::protocol::frame::{Answer, View};
use crate::ptm::Format;
use crate::runner::run::Reply;
use crate::suite::cases::TableSpelling;
use crate::suite::compare::Expected;

use super::calls::Calls;
use super::checklist::{Checklist, Reproduction};
use super::explain::{explain, not_refused};
use super::message::{ProbeFault, Slots, fault};
use super::sample::Sample;
use super::{command, repair};

/// Formats, ordered by the number of readers that support them.
const FORMATS: [Format; 9] = [
    Format::Lrgb,
    Format::Rgb,
    Format::PtmCLut,
    Format::PtmLut,
    Format::Lum,
    Format::JpegRgb,
    Format::JpegLrgb,
    Format::JpeglsRgb,
    Format::JpeglsLrgb,
];

/// A first file that the decoder answered with a frame.
pub(super) struct FirstFrame {
    pub(super) sample: Sample,
    /// The views in which it did.
    pub(super) views: Vec<View>,
}

/// A sample, and the replies to it in each view.
struct Asked {
    sample: Sample,
    replies: Vec<(View, Reply)>,
}

impl Asked {
    fn new(calls: &Calls, sample: Sample) -> Asked {
        let views = [
            View::Raw,
            View::Coef,
            View::ORDINARY_LIGHT.parse().expect("a view"),
        ];
        let ask = |view: View| {
            let reply = calls.ask(&view, &sample.file);
            (view, reply)
        };
        Asked {
            replies: views.into_iter().map(ask).collect(),
            sample,
        }
    }

    /// Requests a format, in the spelling of its table that the decoder reads, if any.
    fn in_best_spelling(calls: &Calls, format: Format) -> Asked {
        let mut best: Option<Asked> = None;
        for sample in Sample::in_all_spellings(format, "5x3") {
            let asked = Asked::new(calls, sample);
            let rank = asked.rank();
            if best.as_ref().is_none_or(|best| rank > best.rank()) {
                best = Some(asked);
            }
            let unsupported = |(_, reply): &(View, Reply)| reply.answer == Answer::Unsupported;
            let settled = best.as_ref().is_some_and(|best| {
                best.rank() == Rank::Right || best.replies.iter().all(unsupported)
            });
            if settled {
                break;
            }
        }
        best.expect("every format has a spelling")
    }

    /// Returns how well the decoder reads the file.
    fn rank(&self) -> Rank {
        let one = |(view, reply): &(View, Reply)| match &reply.answer {
            Answer::Decoded(frame) if self.sample.expected(view).compare(frame).is_none() => {
                Rank::Right
            }
            Answer::Decoded(frame)
                if (frame.width, frame.height)
                    == (self.sample.size.width, self.sample.size.height) =>
            {
                Rank::RightSize
            }
            Answer::Decoded(_) => Rank::Frame,
            _ => Rank::Nothing,
        };
        self.replies.iter().map(one).max().unwrap_or(Rank::Nothing)
    }

    /// Returns true if more files would only take time.
    fn is_hopeless(&self) -> bool {
        self.replies.iter().any(|(_, reply)| {
            matches!(
                reply.answer,
                Answer::NotStarted(_) | Answer::NotAsked(_) | Answer::Hung(_)
            ) || reply.stdout.windows(5).any(|bytes| bytes == b"PTM1 ")
        })
    }
}

/// The quality of a result, worst first.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Rank {
    Nothing,
    Frame,
    RightSize,
    Right,
}

/// Finds a format and views that it decodes; judges the images.
pub(super) fn first_frame(calls: &Calls, list: &mut Checklist) -> Option<FirstFrame> {
    let mut troubled = None;
    let mut lacking = Vec::new();
    for format in FORMATS {
        let asked = Asked::in_best_spelling(calls, format);
        if asked.rank() > Rank::Nothing {
            judge_views(&asked, list);
            if !lacking.is_empty() {
                list.absent(format!("not decoded: {}", lacking.join(", ")));
            }
            let is_frame = |reply: &Reply| matches!(reply.answer, Answer::Decoded(_));
            let offered = asked.replies.into_iter();
            let offered = offered.filter(|(_, reply)| is_frame(reply));
            return Some(FirstFrame {
                sample: asked.sample,
                views: offered.map(|(view, _)| view).collect(),
            });
        }
        lacking.push(format.short_name());
        let hopeless = asked.is_hopeless();
        let mut replies = asked.replies.into_iter();
        let bad = replies.find(|(_, reply)| reply.answer != Answer::Unsupported);
        if let (None, Some((view, reply))) = (&troubled, bad) {
            troubled = Some((asked.sample, view, reply));
        }
        if hopeless {
            break;
        }
    }
    let Some((sample, view, reply)) = troubled else {
        let (says, next) = fault("nothing-supported", &[]);
        list.bad(says, next, None);
        return None;
    };
    let known = why_no_frame(
        calls,
        (&sample.file, &sample.expected(&view)),
        &view,
        &reply,
    );
    let (says, next) = known.unwrap_or_else(|| explain(&reply));
    let says = format!("{} {view}: {says}", sample.format.short_name());
    list.bad(says, next, sample.repeat(&view));
    None
}

/// Reports for each view of a file whether it is right, and if not, the repair.
fn judge_views(asked: &Asked, list: &mut Checklist) {
    let sample = &asked.sample;
    let name = sample.format.short_name();
    if sample.spelling != TableSpelling::default() {
        let newline = match sample.spelling.newline {
            true => " and a line feed stands after the table",
            false => "",
        };
        let count = sample.spelling.count.name();
        list.good(format!(
            "{name}: read where the number of entries is written \"{count}\"{newline}"
        ));
    }
    for (view, reply) in &asked.replies {
        let what = format!("{name} {view}");
        let wrong = match &reply.answer {
            Answer::Decoded(frame) => match sample.expected(view).compare(frame) {
                None => {
                    list.good(format!("{what}: decoded, and the picture is right"));
                    continue;
                }
                Some(difference) => fault("wrong-image", &[("difference", &difference)]),
            },
            Answer::Unsupported => {
                list.absent(format!(
                    "{what}: exited with 69, so this view is not offered, and not needed"
                ));
                continue;
            }
            answer => fault("no-image", &[("answer", &answer.describe())]),
        };
        let repair = repair::repair(&reply.stdout, &sample.expected(view), view);
        let (says, next) = repair.map_or(wrong, |repair| repair.fault());
        list.bad(format!("{what}: {says}"), next, sample.repeat(view));
    }
}

/// Explains an answer that is not a frame, if its cause is known.
pub(super) fn why_no_frame(
    calls: &Calls,
    (file, expected): (&[u8], &Expected),
    view: &View,
    reply: &Reply,
) -> Option<ProbeFault> {
    let repair = repair::repair(&reply.stdout, expected, view).map(|repair| repair.fault());
    let known = repair.or_else(|| command::not_run(calls.command, reply));
    // A decoder that times out would time out in every way of being called.
    if known.is_some() || matches!(reply.answer, Answer::Hung(_)) {
        return known;
    }
    calls.other_way(file, expected, view)
}

/// Requests a frame that is larger than the buffer of a pipe.
pub(super) fn large_frame(calls: &Calls, first: &FirstFrame, list: &mut Checklist) {
    let sample = Sample::new(first.sample.format, "201x149", first.sample.spelling);
    for view in &first.views {
        let reply = calls.ask(view, &sample.file);
        let what = format!("a frame of {} texels in {view}", sample.size.texels());
        let (says, next) = match &reply.answer {
            Answer::Decoded(frame)
                if (frame.width, frame.height) == (sample.size.width, sample.size.height) =>
            {
                list.good(format!("{what}: complete"));
                continue;
            }
            Answer::Decoded(frame) => {
                let (width, height, size) = (frame.width, frame.height, sample.size);
                let slots: &Slots = &[("width", &width), ("height", &height), ("size", &size)];
                fault("large-size", slots)
            }
            _ => explain(&reply),
        };
        list.bad(format!("{what}: {says}"), next, sample.repeat(view));
    }
}

/// Requests files that every decoder must refuse.
pub(super) fn refusals(calls: &Calls, first: &FirstFrame, list: &mut Checklist) {
    let (whole, view) = (&first.sample.file, &first.views[0]);
    for (what, file_name, file) in malformed(whole) {
        let reply = calls.ask(view, file);
        if reply.answer == Answer::Rejected {
            list.good(format!("{what}: refused with 65"));
            continue;
        }
        let (says, next) = not_refused(&reply);
        let repeat = Reproduction::one_shot(view, file_name, file);
        list.bad(format!("{what}: {says}"), next, repeat);
    }
}

/// Returns files that every decoder must refuse: a description, a name, and the bytes of each.
pub(super) fn malformed(whole: &[u8]) -> [(&'static str, &'static str, &[u8]); 3] {
    [
        ("an empty file", "empty.ptm", b""),
        (
            "a file that is no PTM",
            "no.ptm",
            b"\x89PNG\r\n\x1a\n, which this is not either",
        ),
        (
            "a PTM that ends too soon",
            "cut-short.ptm",
            &whole[..whole.len() - 7],
        ),
    ]
}

/// Requests a view that does not exist.
pub(super) fn unknown_view(calls: &Calls, sample: &Sample, list: &mut Checklist) {
    const UNKNOWN: &str = "no-such-view";
    let reply = calls.ask_for(UNKNOWN, &["{in}"], &sample.file);
    let (says, next) = match &reply.answer {
        Answer::Unsupported => return list.good("an unknown view: exited with 69"),
        Answer::Decoded(_) => fault("unknown-view-shown", &[]),
        answer => fault("unknown-view", &[("answer", &answer.describe())]),
    };
    let repeat = Reproduction::one_shot(&UNKNOWN, sample.file_name(), &sample.file);
    list.bad(format!("an unknown view: {says}"), next, repeat);
}

/// Requests the capabilities.
pub(super) fn capabilities(calls: &Calls, list: &mut Checklist) {
    let reply = calls.ask_for("capabilities", &[], b"");
    let text = String::from_utf8_lossy(&reply.stdout);
    let says_so = text.lines().any(|line| line.trim_end() == "protocol: 1");
    if reply.exit == Some(0) && says_so {
        list.good("capabilities: declared");
    } else {
        list.absent("capabilities: not declared, and not needed");
    }
}
