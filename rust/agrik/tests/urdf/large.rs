//! Large texts: read in time that grows with their size, or refused by a stated limit.

use std::fmt::Write;
use std::time::{Duration, Instant};

use agrik::Error;
use agrik::chain::Chain;

use crate::{LIMIT, joint, refused, robot};

const MANY: usize = 100_000;

/// Far above what is needed, far below what a square of `MANY` takes.
const SOON: Duration = Duration::from_secs(20);

/// Links `l0` to `l{count}`.
fn links(count: usize) -> String {
    (0..=count).fold(String::new(), |mut text, i| {
        write!(text, "l{i} ").expect("a text takes all");
        text
    })
}

fn in_row(count: usize, inside: impl Fn(usize) -> String) -> String {
    let joints: String = (0..count)
        .map(|i| {
            joint(&format!("j{i}"), "fixed", &format!("l{i}"), &format!("l{}", i + 1), &inside(i))
        })
        .collect();
    robot(&links(count), &joints)
}

#[test]
fn many_joints_beside_the_chain_are_read_in_linear_time() {
    let side: String = (1..MANY)
        .map(|i| joint(&format!("j{i}"), "fixed", &format!("l{}", i - 1), &format!("l{i}"), ""))
        .collect();
    let arm = joint("arm", "revolute", "l0", &format!("l{MANY}"), LIMIT);
    let text = robot(&links(MANY), &(side + &arm));
    let start = Instant::now();
    let chain = Chain::from_urdf(&text, None, Some(&format!("l{MANY}"))).expect("a chain");
    assert_eq!(chain.dof(), 1);
    // Of the two leaves only one is moved.
    let chain = Chain::from_urdf(&text, None, None).expect("a chain");
    assert_eq!(chain.joints().last().map(|j| j.child_link.as_str()), Some(&*format!("l{MANY}")));
    assert!(start.elapsed() < SOON);
}

#[test]
fn many_leaves_below_a_long_row_are_found_in_linear_time() {
    let half = MANY / 2;
    let leaves: String = (half..MANY)
        .map(|i| joint(&format!("k{i}"), "fixed", &format!("l{half}"), &format!("l{}", i + 1), ""))
        .collect();
    let row: String = (0..half)
        .map(|i| joint(&format!("j{i}"), "fixed", &format!("l{i}"), &format!("l{}", i + 1), ""))
        .collect();
    let text = robot(&links(MANY), &(row + &leaves));
    let start = Instant::now();
    for base in [None, Some("l1")] {
        let error = Chain::from_urdf(&text, base, None).expect_err("many leaves");
        assert!(error.to_string().contains("50000 links could be the tip"), "{error}");
    }
    assert!(start.elapsed() < SOON);
}

#[test]
fn longer_rows_of_joints_are_refused() {
    let message = "4001 joints between base and tip, expected at most 4000";
    refused(&in_row(4001, |_| String::new()), None, None, message);
}

#[test]
fn longer_rows_of_followers_are_refused() {
    let follower = |i: usize| format!("{LIMIT}<mimic joint=\"j{}\"/>", i + 1);
    let text = in_row(200, |i| if i < 199 { follower(i) } else { LIMIT.to_string() });
    let text = text.replace("type=\"fixed\"", "type=\"revolute\"");
    let line = 203;
    let message = format!(
        "joint 'j0' (line {line}): <mimic> leads back to itself or over more than 100 joints"
    );
    refused(&text, None, None, &message);
}

#[test]
fn long_unknown_names_are_refused_at_once() {
    let long = "x".repeat(100_000);
    let text = robot("a b", &joint("j", "revolute", &long, "b", LIMIT));
    let start = format!("{}...", &long[..60]);
    refused(&text, None, None, &format!("joint 'j' (line 4): unknown parent link '{start}'"));
    let named = robot(&"n".repeat(1001), "");
    let message = "line 2: <link> with a name of 1001 bytes, expected at most 1000";
    refused(&named, None, None, message);
}

#[test]
fn elements_of_many_attributes_and_long_texts_are_refused() {
    let attributes = (0..MANY).fold(String::new(), |mut text, i| {
        write!(text, " a{i}=\"\"").expect("a text takes all");
        text
    });
    let text = format!("<robot>\n<link{attributes}/></robot>");
    refused(&text, None, None, "line 2: an element of more than 64 attributes");
    let text = format!("<robot>{}</robot>", " ".repeat(16 << 20));
    let message = "a text of 16777231 bytes, expected at most 16777216";
    refused(&text, None, None, message);
}

#[test]
fn deep_elements_are_passed_over() {
    let inside = format!("{}{}", "<a>".repeat(MANY), "</a>".repeat(MANY));
    let text = robot("a b", &joint("j", "revolute", "a", "b", &format!("{LIMIT}{inside}")));
    assert_eq!(Chain::from_urdf(&text, None, None).map(|chain| chain.dof()), Ok::<_, Error>(1));
}
