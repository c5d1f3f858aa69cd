#!/usr/bin/env bash
# finding: For a PTM with a space after "PTM_1.2", fido falls back to the extension and also names Microsoft MapPoint.
# software: opf-fido 1.6.1 (PRONOM v109)
# expected: fmt/519 by signature for both files, because the space is legal white space.
# observed: PTM_1.2 and a newline: fmt/519 by signature
# observed: PTM_1.2, a space and a newline: fmt/1362 fmt/519 by extension
. "$(dirname "$0")/tools.sh"
python_packages opf-fido==1.6.1 setuptools==80.9.0
cd "$work"
body='PTM_FORMAT_LRGB\n1\n1\n1 1 1 1 1 1\n0 0 0 0 0 0\nabcdefghi'
printf "PTM_1.2\n$body" > plain.ptm
printf "PTM_1.2 \n$body" > space.ptm
identify() {
    "$work/venv/bin/fido" -q -matchprintf '%(info.puid)s %(info.matchtype)s\n' "$1" 2> "$work/errors" | tr -d '\r' > rows
    echo "$2: $(cut -d' ' -f1 rows | sort | xargs) by $(cut -d' ' -f2 rows | sort -u)"
}
{ identify plain.ptm "PTM_1.2 and a newline"; identify space.ptm "PTM_1.2, a space and a newline"; } | confirm
