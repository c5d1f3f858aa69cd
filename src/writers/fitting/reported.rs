//! The part of the fitter suite that only reports need.

use maud::{Markup, html};

use crate::diagnose::Causes;
use crate::kit::digest::sha256;
use crate::misreadings::Misreading;
use crate::ptm::Format;
use crate::report::reported::Reported;
use crate::runner::write::Attachment;
use crate::session::observation::Observation;
use crate::session::run::Run;
use crate::suite::cases::{Suite, TableSpelling};
use crate::suite::name::SuiteName;
use crate::writers::asking::{Sent, WritingCase};
use crate::writers::fitting::cases::{BuiltFit, FitCase, diagnose};

impl WritingCase for FitCase {
    const VERB: &'static str = "fit";

    fn format(&self) -> Format {
        self.format
    }

    fn is_smoke(&self) -> bool {
        true
    }

    fn sent(built: &BuiltFit) -> Sent {
        let lp = Attachment {
            name: "lp".to_owned(),
            file_name: "lights.lp".to_owned(),
            bytes: built.set.lp().into_bytes(),
        };
        let pictures = built.set.photographs.iter().enumerate();
        let pictures = pictures.map(|(k, of)| Attachment {
            name: format!("picture-{k}"),
            file_name: of.name.clone(),
            bytes: of.png(built.set.size),
        });
        Sent {
            json: String::from_utf8_lossy(&built.json).into_owned(),
            attachments: [lp].into_iter().chain(pictures).collect(),
            values: vec![
                ("width", built.set.size.width.to_string()),
                ("height", built.set.size.height.to_string()),
            ],
        }
    }
}

impl Reported for FitCase {
    const SUITE: SuiteName = SuiteName::Fitters;

    type Place = &'static Misreading;

    fn suite() -> Result<Suite<FitCase>, String> {
        Ok(Suite::of_photographs(None))
    }

    fn digest(suite: &Suite<FitCase>) -> String {
        let digests = suite.cases.iter().map(|case| {
            let set = case.photographs();
            let pixels = set.photographs.iter().flat_map(|of| &of.pixels).copied();
            let lp = set.lp().into_bytes();
            sha256(&lp.into_iter().chain(pixels).collect::<Vec<u8>>())
        });
        sha256(digests.collect::<String>().as_bytes())
    }

    fn evidence(&self, _: TableSpelling, observation: &Observation<FitCase>) -> Markup {
        html! {
            p.label { "Lights and images" }
            pre.bytes tabindex="0" { (self.photographs().lp()) }
            @if !observation.stderr.is_empty() {
                p.label { "Its standard error" }
                pre.stderr tabindex="0" { (observation.stderr) }
            }
        }
    }

    fn diagnose(
        suite: &Suite<FitCase>,
        run: &Run<FitCase>,
        _: &[String],
        _: usize,
    ) -> Causes<&'static Misreading> {
        diagnose(suite, run).into()
    }
}
