"""A JPEG-LS encoder (T.87) for one component, with every parameter of the standard. For the streams of codecs.py."""

RUN_LENGTHS = [0] * 4 + [1] * 4 + [2] * 4 + [3] * 4 + [4, 4, 5, 5, 6, 6, 7, 7, 8, 9, 10, 11, 12, 13, 14, 15]     # J


def default_thresholds(maxval, near):
    """Returns T1, T2, T3 (C.2.4.1.1.1)."""
    def clamp(value, low):
        return low if value > maxval or value < low else value
    if maxval >= 128:
        factor = (min(maxval, 4095) + 128) // 256
        low = clamp(factor * 1 + 2 + 3 * near, near + 1)
        middle = clamp(factor * 4 + 3 + 5 * near, low)
        return low, middle, clamp(factor * 17 + 4 + 7 * near, middle)
    factor = 256 // (maxval + 1)
    low = clamp(max(2, 3 // factor + 3 * near), near + 1)
    middle = clamp(max(3, 7 // factor + 5 * near), low)
    return low, middle, clamp(max(4, 21 // factor + 7 * near), middle)


class Bits:
    """Bits from the highest to the lowest. After a byte FF, the next one has seven bits (A.1)."""

    def __init__(self):
        self.out, self.byte, self.free = bytearray(), 0, 8

    def put(self, value, count):
        for at in reversed(range(count)):
            self.free -= 1
            self.byte |= (value >> at & 1) << self.free
            if self.free == 0:
                self.out.append(self.byte)
                self.byte, self.free = 0, 7 if self.byte == 0xFF else 8

    def finish(self):
        if self.free < 8:
            self.out.append(self.byte)
            if self.byte == 0xFF:
                self.out.append(0)
        return bytes(self.out)


def encode_scan(samples, width, height, bits=8, near=0, maxval=0, t1=0, t2=0, t3=0, reset=0):
    """Returns the bytes of the scan and the samples that a decoder must return. A parameter of 0 means its default value."""
    maxval = maxval or (1 << bits) - 1
    thresholds = [given or value for given, value in zip((t1, t2, t3), default_thresholds(maxval, near))]
    reset = reset or 64
    step = 2 * near + 1
    span = (maxval + 2 * near) // step + 1                       # RANGE
    qbpp = (span - 1).bit_length()
    bpp = max(2, maxval.bit_length())
    limit = 2 * (bpp + max(8, bpp))
    start = max(2, (span + 32) // 64)
    a, n = [start] * 367, [1] * 367
    b, c, nn = [0] * 367, [0] * 367, [0, 0]
    run_index, out = 0, Bits()

    def quantize(d):
        size = 0 if abs(d) <= near else 1 + sum(abs(d) >= t for t in thresholds)
        return -size if d < 0 else size

    def quantize_error(error):
        if near:
            error = (error + near) // step if error > 0 else -((near - error) // step)
        return error

    def reduce(error):
        if error < 0:
            error += span
        return error - span if error >= (span + 1) // 2 else error

    def reconstruct(prediction, error):
        value = prediction + error * step
        if value < -near:
            value += span * step
        elif value > maxval + near:
            value -= span * step
        return min(max(value, 0), maxval)

    def golomb(value, k, most):
        high = value >> k
        if high < most - qbpp - 1:
            out.put(1, high + 1)
            out.put(value & ((1 << k) - 1), k)
        else:
            out.put(1, most - qbpp)
            out.put(value - 1, qbpp)

    previous, corner, result = [0] * width, 0, bytearray()
    for y in range(height):
        row = []
        x = 0
        while x < width:
            ra = row[x - 1] if x else previous[0]
            rb = previous[x]
            rc = previous[x - 1] if x else corner
            rd = previous[x + 1] if x + 1 < width else rb
            q = [quantize(rd - rb), quantize(rb - rc), quantize(rc - ra)]
            sample = samples[y * width + x]
            if q == [0, 0, 0]:
                run = 0
                while x < width and abs(samples[y * width + x] - ra) <= near:
                    row.append(ra)
                    run, x = run + 1, x + 1
                while run >= 1 << RUN_LENGTHS[run_index]:
                    out.put(1, 1)
                    run -= 1 << RUN_LENGTHS[run_index]
                    run_index = min(run_index + 1, 31)
                if x == width:
                    if run:
                        out.put(1, 1)
                    break
                out.put(0, 1)
                out.put(run, RUN_LENGTHS[run_index])
                sample, rb = samples[y * width + x], previous[x]
                kind = int(abs(ra - rb) <= near)
                prediction = ra if kind else rb
                sign = -1 if not kind and ra > rb else 1
                error = quantize_error(sign * (sample - prediction))
                row.append(reconstruct(prediction, sign * error))
                error = reduce(error)
                context = 365 + kind
                temporary = a[context] + (n[context] >> 1 if kind else 0)
                k = 0
                while n[context] << k < temporary:
                    k += 1
                if k == 0 and error > 0 and 2 * nn[kind] < n[context]:
                    flip = 1
                elif error < 0 and (2 * nn[kind] >= n[context] or k != 0):
                    flip = 1
                else:
                    flip = 0
                mapped = 2 * abs(error) - kind - flip
                golomb(mapped, k, limit - RUN_LENGTHS[run_index] - 1)
                nn[kind] += error < 0
                a[context] += (mapped + 1 - kind) >> 1
                if n[context] == reset:
                    a[context], n[context], nn[kind] = a[context] >> 1, n[context] >> 1, nn[kind] >> 1
                n[context] += 1
                run_index = max(run_index - 1, 0)
                x += 1
                continue
            sign = 1
            if next(value for value in q if value) < 0:
                sign, q = -1, [-value for value in q]
            context = (q[0] * 9 + q[1]) * 9 + q[2]
            prediction = min(ra, rb) if rc >= max(ra, rb) else max(ra, rb) if rc <= min(ra, rb) else ra + rb - rc
            prediction = min(max(prediction + sign * c[context], 0), maxval)
            error = quantize_error(sign * (sample - prediction))
            row.append(reconstruct(prediction, sign * error))
            error = reduce(error)
            k = 0
            while n[context] << k < a[context]:
                k += 1
            if near == 0 and k == 0 and 2 * b[context] <= -n[context]:
                mapped = 2 * error + 1 if error >= 0 else -2 * (error + 1)
            else:
                mapped = 2 * error if error >= 0 else -2 * error - 1
            golomb(mapped, k, limit)
            b[context] += error * step
            a[context] += abs(error)
            if n[context] == reset:
                a[context], b[context], n[context] = a[context] >> 1, b[context] >> 1, n[context] >> 1
            n[context] += 1
            if b[context] <= -n[context]:
                b[context] = max(b[context] + n[context], 1 - n[context])
                c[context] = max(c[context] - 1, -128)
            elif b[context] > 0:
                b[context] = min(b[context] - n[context], 0)
                c[context] = min(c[context] + 1, 127)
            x += 1
        corner, previous = previous[0], row
        result += bytes(row)
    return out.finish(), bytes(result)


def segment(code, body):
    return bytes([0xFF, code]) + (len(body) + 2).to_bytes(2, "big") + body


def encode(samples, width, height, component=1, presets=None, bits=8, near=0, before=b"", between=b"", after=b"", fill=b"", dnl=False):
    """Returns a stream and the samples that a decoder must return. `presets` are MAXVAL, T1, T2, T3, RESET, as written."""
    names = "maxval", "t1", "t2", "t3", "reset"
    scan, result = encode_scan(samples, width, height, bits, near, **dict(zip(names, presets or [])))
    lse = segment(0xF8, b"\1" + b"".join(value.to_bytes(2, "big") for value in presets)) if presets else b""
    size = (0 if dnl else height).to_bytes(2, "big") + width.to_bytes(2, "big")
    frame = segment(0xF7, bytes([bits]) + size + bytes([1, component, 0x11, 0]))
    start = segment(0xDA, bytes([1, component, 0, near, 0, 0]))
    lines = segment(0xDC, height.to_bytes(2, "big")) if dnl else b""
    return b"\xff\xd8" + before + fill + frame + fill + between + lse + fill + start + scan + lines + b"\xff\xd9" + after, result
