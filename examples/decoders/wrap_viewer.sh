#!/bin/sh
# Makes a decoder of a viewer that only writes pictures.
#
#     wrap_viewer.sh VIEW FILE          as any decoder is called: rgb:LU,LV is answered, other views are not offered
#
# As it stands the viewer is called as `$VIEWER LU LV FILE PICTURE`; write the call of yours into show() below. PICTURE is
# a PNG, PNM, TIFF, BMP, WebP or JPEG; its bytes are the answer, because frames in these forms are understood as they are.
#
#     VIEWER=./my-viewer ptm-conform check examples/decoders/wrap_viewer.sh
#
# Exit status: 0 an image, 65 the viewer finds the file malformed, 69 it does not read it. Only the viewer can know. Most
# end with 1 for everything; what is then a refusal is told here from their words, and what is left stays a crash.

show() { # LU LV FILE PICTURE
    ${VIEWER:?names no viewer} "$1" "$2" "$3" "$4"
}

case $1 in
    rgb:*,*) ;;
    *) exit 69 ;;
esac
light=${1#rgb:}

# Temporary files go where the working directory is: it is empty, and is cleared away after the call.
if show "${light%%,*}" "${light#*,}" "$2" picture >&2 2> words && [ -s picture ]; then
    cat words >&2
    cat picture
    exit 0
fi
status=$?
cat words >&2
case $status in
    65 | 69) exit "$status" ;;
esac
if grep -q -i -e unsupported -e 'not implemented' words; then exit 69; fi
if grep -q -i -e malformed -e invalid -e corrupt -e 'not a ptm' words; then exit 65; fi
[ "$status" -ne 0 ] || status=70 # success without an image
exit "$status"
