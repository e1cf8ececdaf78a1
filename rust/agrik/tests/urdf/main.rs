//! URDF texts: what is read, which chain is chosen, and how bad texts are refused.

#[path = "../common/mod.rs"]
mod common;
mod large;
mod reading;
mod refusals;

use agrik::Error;
use agrik::chain::Chain;

/// A robot of some links and joints.
pub fn robot(links: &str, joints: &str) -> String {
    let links: String =
        links.split_whitespace().map(|name| format!("<link name=\"{name}\"/>\n")).collect();
    format!("<robot name=\"r\">\n{links}{joints}</robot>")
}

/// A joint with more elements inside.
pub fn joint(name: &str, kind: &str, parent: &str, child: &str, inside: &str) -> String {
    format!(
        "<joint name=\"{name}\" type=\"{kind}\"><parent link=\"{parent}\"/>\
         <child link=\"{child}\"/>{inside}</joint>\n"
    )
}

/// Limits that most joints here have.
pub const LIMIT: &str = "<limit lower=\"-1\" upper=\"2\" effort=\"1\" velocity=\"1\"/>";

/// Asserts that a text is refused with this message.
#[track_caller]
pub fn refused(text: &str, base: Option<&str>, tip: Option<&str>, message: &str) {
    let error = Chain::from_urdf(text, base, tip).expect_err(message);
    assert_eq!(error, Error::Description { format: "URDF", message: message.to_string() });
}
