//! Texts of a suite that reports show. With them, the same code renders reports on any suite.

use std::collections::HashMap;

use ptm_suite::cases::Suite;
use ptm_suite::clauses::{self, Clause, Ruling};
use ptm_suite::{name::SuiteName, test_case::Listed, texture};

/// Texts of a suite.
pub struct SuiteTexts {
    /// Id and purpose of each case.
    pub cases: Vec<(String, String)>,
    /// The short name of the format of each case, by id; empty if the cases have no format.
    pub formats: HashMap<String, &'static str>,
    /// The clauses that the suite tests.
    pub clauses: Vec<Clause>,
    /// The rulings on open questions of the specification.
    pub rulings: Vec<Ruling>,
    /// Id of each ruling that allows several readings, and name of the reading of the reference.
    pub reference_readings: Vec<(&'static str, &'static str)>,
}

impl SuiteTexts {
    /// Reads the texts of a suite.
    ///
    /// # Errors
    /// Returns a message that names the file and the error.
    pub fn new<C: Listed>(suite: &Suite<C>) -> Result<SuiteTexts, String> {
        let purpose = |case: &C| (case.id().to_owned(), case.because());
        let (clauses, rulings) = match C::SUITE {
            SuiteName::Texture => (texture::cases::clauses()?, texture::cases::rulings()?),
            SuiteName::Ptm | SuiteName::Writers | SuiteName::Fitters => {
                (clauses::clauses()?, clauses::rulings()?)
            }
        };
        Ok(SuiteTexts {
            cases: suite.cases.iter().map(purpose).collect(),
            formats: suite
                .cases
                .iter()
                .filter_map(|case| Some((case.id().to_owned(), case.format_name()?)))
                .collect(),
            clauses,
            rulings,
            reference_readings: C::reference_readings(),
        })
    }

    /// Returns the purpose of a case, in one or more lines, or `None` if the suite does not contain the case.
    #[must_use]
    pub fn purpose(&self, id: &str) -> Option<&str> {
        let mut cases = self.cases.iter();
        let case = cases.find(|(case, _)| case == id);
        case.map(|(_, purpose)| purpose.as_str())
    }
}
