//! Tests of writers that violate the protocol: each one receives the expected verdict and leaves no file.

use std::fs;

use crate::common::{Workspace, outcome, rows};

/// Faulty writers in `sh`, each with a part of the expected message. `$2` is the request and `$3` the output path.
const WRITERS: &str = r#"
true | the output file is missing, although the program exited with 0
: > "$3" | the output file is empty
mkdir "$3" | the output file is not a regular file
mkfifo "$3" | the output file is not a regular file
ln -s /etc/hostname "$3" | the output file is a link
ln -s ../../.. "$3" | the output file is a link
d=$(dirname "$3"); cd /; rm -r "$d" && ln -s /etc "$d" | the output file is missing
printf 'PTM_1.2\nPTM_FORMAT_RGB\n3\n2\n' > "$3" | the reference refuses the file
chmod u+w "$2"; echo x >> "$2" | tampering
p=$(dirname "$2")/planes.npy; chmod u+w "$p" && echo x >> "$p" | tampering
head -c 10000000000 /dev/zero > "$3" | in the output file
truncate -s 10G "$3" || exit 1 |
truncate -s 60M "$3" | in the output file
sleep 1000 | exceeds the time limit of 3 s (`--timeout`)
yes > "$3" | in the output file
"#;

#[test]
fn hostile_writers_get_the_listed_verdicts_and_leave_no_file() {
    for [script, says] in rows(WRITERS) {
        let here = Workspace::new();
        let temporary = here.path("temporary");
        fs::create_dir(&temporary).expect("a directory");
        let output = here
            .command("check-writer --case first-* --timeout 1 --report report.yaml -- sh -c")
            .args([&script, "hostile"])
            .env("TMPDIR", &temporary)
            .output();
        let (status, text) = outcome(&output.expect("the program starts"));
        assert!(matches!(status, 1 | 3), "{script}: {status}: {text}");
        assert!(text.contains(&says), "{script}: {text}");
        let left = fs::read_dir(&temporary).expect("a directory").count();
        assert_eq!(left, 0, "{script}");
    }
}
