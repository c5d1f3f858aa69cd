#!/bin/sh
# Turns a viewer that only writes images into a decoder.
#
#     wrap_viewer.sh VIEW FILE          the call of any decoder; only the view rgb:LU,LV is supported
#
# It calls `$VIEWER LU LV FILE IMAGE`. Replace this in show() below with the call of your viewer. IMAGE is a PNG, PNM, TIFF,
# BMP, WebP or JPEG. Its bytes are the answer, because ptm-conform reads these forms.
#
#     VIEWER=./my-viewer ptm-conform check examples/decoders/wrap_viewer.sh
#
# Exit status: 0 an image, 65 a malformed file, 69 an unsupported file. Only the viewer knows the difference. Most viewers
# exit with 1 for all errors; this script then recognizes refusals by their messages. All other errors stay crashes.

show() { # LU LV FILE IMAGE
    ${VIEWER:?set VIEWER to the command of the viewer} "$1" "$2" "$3" "$4"
}

case $1 in
    rgb:*,*) ;;
    *) exit 69 ;;
esac
light=${1#rgb:}

# Temporary files go to the working directory, which is empty and is removed after the call.
if show "${light%%,*}" "${light#*,}" "$2" image >&2 2> messages && [ -s image ]; then
    cat messages >&2
    cat image
    exit 0
fi
status=$?
cat messages >&2
case $status in
    65 | 69) exit "$status" ;;
esac
if grep -q -i -e unsupported -e 'not implemented' messages; then exit 69; fi
if grep -q -i -e malformed -e invalid -e corrupt -e 'not a ptm' messages; then exit 65; fi
[ "$status" -ne 0 ] || status=70 # success without an image
exit "$status"
