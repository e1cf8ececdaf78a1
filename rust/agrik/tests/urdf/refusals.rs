//! How texts are refused that describe no usable chain.

use agrik::chain::Chain;

use crate::{LIMIT, joint, refused, robot};

#[test]
fn texts_that_are_not_urdf() {
    for (text, message) in [
        ("", "the text is empty"),
        (" \n\t ", "the text is empty"),
        ("panda.urdf", "not XML: no <robot> element in a text that starts with 'panda.urdf'"),
        (
            "<!-- only a remark -->",
            "not XML: no <robot> element in a text that starts with '<!-- only a remark -->'",
        ),
        ("<sdf version=\"1.6\"></sdf>", "the root element is <sdf>, not <robot>"),
        ("<robot>\n<link name=\"a\">\n", "the text ends inside <link>, which starts on line 2"),
        ("<robot/><robot/>", "line 1: a second root element"),
        ("<robot name=\"r\"/>", "no <link> in <robot>"),
        (
            "<robot><xacro:include filename=\"a.xacro\"/></robot>",
            "no <link> in <robot>; this looks like a xacro file, expand it first",
        ),
        ("<robot>\n<link/></robot>", "line 2: <link> without a name"),
        ("<robot>\n<link name=\" \"/></robot>", "line 2: <link> without a name"),
    ] {
        refused(text, None, None, message);
    }
}

#[test]
fn xml_that_is_not_well_formed_names_the_line() {
    for (text, line) in [
        ("<robot>\n<link name=\"a\"></robot>", 2),
        ("<robot>\n\n<link name=a/></robot>", 3),
        ("<robot>\n<link name=\"a\" name=\"b\"/></robot>", 2),
        ("<robot>\n<link name=\"&nope;\"/></robot>", 2),
        ("<robot>\n<link name=\"a\"", 2),
    ] {
        let error = Chain::from_urdf(text, None, None).expect_err(text).to_string();
        let start = format!("URDF: not well-formed XML at line {line}: ");
        assert!(error.starts_with(&start), "{error}");
    }
}

#[test]
fn structures_that_are_not_one_tree() {
    let ab = joint("j1", "revolute", "a", "b", LIMIT);
    let ba = joint("j2", "revolute", "b", "a", LIMIT);
    for (links, joints, message) in [
        ("a b", ba.clone() + &ab, "cyclic: from link 'a' joints 'j1', 'j2' lead back to it"),
        ("c a b", ba.clone() + &ab, "cyclic: from link 'a' joints 'j1', 'j2' lead back to it"),
        (
            "a",
            joint("j", "fixed", "a", "a", ""),
            "cyclic: from link 'a' joints 'j' lead back to it",
        ),
        (
            "a b c d",
            ab.clone() + &joint("j3", "fixed", "c", "d", ""),
            "disconnected: 2 links have no parent joint ('a', 'c'), expected one root",
        ),
        (
            "a b c",
            ab.clone() + &joint("j3", "fixed", "c", "b", ""),
            "link 'b' is the child of two joints, 'j1' and 'j3': not a tree",
        ),
        ("a b a", ab.clone(), "line 4: a second link named 'a', the first is on line 2"),
        (
            "a b c",
            ab.clone() + &joint("j1", "fixed", "b", "c", ""),
            "line 6: a second joint named 'j1'",
        ),
        (
            "a tool0",
            joint("j", "fixed", "a", "tol0", ""),
            "joint 'j' (line 4): unknown child link 'tol0'; did you mean 'tool0'?",
        ),
        (
            "a b",
            "<joint name=\"j\"><child link=\"b\"/></joint>".to_string(),
            "joint 'j' (line 4): no <parent link=\"...\"/>",
        ),
        ("a b", "<joint type=\"fixed\"/>".to_string(), "line 4: <joint> without a name"),
        ("a", String::new(), "no joint below base link 'a'"),
    ] {
        refused(&robot(links, &joints), None, None, message);
    }
}

#[test]
fn joints_that_cannot_be_used() {
    for (kind, inside, message) in [
        (
            "revolute",
            "",
            "joint 'j' (line 4) is revolute and needs <limit lower=\"...\" upper=\"...\"/> (or the \
             type continuous)",
        ),
        (
            "prismatic",
            "<limit effort=\"1\" velocity=\"1\"/>",
            "joint 'j' (line 4) is prismatic and needs <limit lower=\"...\" upper=\"...\"/>",
        ),
        (
            "revolute",
            "<limit lower=\"2\" upper=\"1\"/>",
            "joint 'j' (line 4): lower limit 2 > upper limit 1",
        ),
        (
            "revolute",
            "<limit lower=\"low\" upper=\"1\"/>",
            "joint 'j' (line 4): <limit> lower: expected a finite number, got 'low'",
        ),
        (
            "revolute",
            "<limit lower=\"nan\" upper=\"1\"/>",
            "joint 'j' (line 4): <limit> lower: expected a finite number, got 'nan'",
        ),
        (
            "continuous",
            "<axis xyz=\"0 0 0\"/>",
            "joint 'j' (line 4): the axis is zero, expected a direction",
        ),
        (
            "continuous",
            "<axis xyz=\"0 0 nan\"/>",
            "joint 'j' (line 4): <axis> xyz: expected three finite numbers, got '0 0 nan'",
        ),
        (
            "continuous",
            "<origin xyz=\"1,2,3\"/>",
            "joint 'j' (line 4): <origin> xyz: expected three finite numbers, got '1,2,3'",
        ),
        (
            "continuous",
            "<origin rpy=\"0 0 ${pi/2}\"/>",
            "joint 'j' (line 4): <origin> rpy: expected three finite numbers, got '0 0 ${pi/2}' \
             (a xacro expression: expand the file first)",
        ),
        ("continuous", "<mimic/>", "joint 'j' (line 4): <mimic> names no joint"),
        ("continuous", "<mimic joint=\"k\"/>", "joint 'j' (line 4): <mimic>: unknown joint 'k'"),
        ("continuous", "<mimic joint=\"j\"/>", "joint 'j' (line 4): <mimic> leads back to itself"),
        ("", "", "joint 'j' (line 4) has no type"),
        (
            "planar",
            "",
            "joint 'j' (line 4) is planar: it has several degrees of freedom and cannot lie \
             between base and tip; choose a base_link below it",
        ),
    ] {
        refused(&robot("a b", &joint("j", kind, "a", "b", inside)), None, None, message);
    }
}

#[test]
fn followers_that_cannot_be_used() {
    let follower = |first: &str, second: &str| {
        let mimic = format!("{second}<mimic joint=\"a\"/>");
        robot("l0 l1 l2", &(first.to_string() + &joint("b", "prismatic", "l1", "l2", &mimic)))
    };
    refused(
        &follower(&joint("a", "fixed", "l0", "l1", ""), LIMIT),
        None,
        None,
        "joint 'b' (line 6): <mimic> follows 'a', which does not move",
    );
    refused(
        &follower(&joint("a", "revolute", "l0", "l1", LIMIT), "<limit lower=\"5\" upper=\"6\"/>"),
        None,
        None,
        "joint 'b' mimic: expected limits that overlap those of its source, got none in common",
    );
    refused(
        &follower(&joint("a", "revolute", "l0", "l1", ""), ""),
        None,
        None,
        "joint 'a' (line 5) is revolute and needs <limit lower=\"...\" upper=\"...\"/> (or the \
         type continuous)",
    );
}
