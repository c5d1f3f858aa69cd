// The JavaScript libraries as plane codecs, with the protocol of worker.py: node worker.mjs FOLDER NAME, where FOLDER has node_modules.
import { createRequire } from 'node:module'
import { pathToFileURL } from 'node:url'
import fs from 'node:fs'
import path from 'node:path'

const [folder, name] = process.argv.slice(2)
const require = createRequire(path.join(folder, 'package.json'))
const packageFile = file => path.join(folder, 'node_modules', file)

// The libraries print to standard output; the answers go to the descriptor.
console.log = console.info = console.warn = console.error

function rgba(samples, channels = 4) {
  const pixels = Buffer.alloc(samples.length * channels, 255)
  for (let i = 0; i < samples.length; i++) pixels.fill(samples[i], i * channels, i * channels + 3)
  return pixels
}

async function emscripten(packageName, script, wasm) {
  const factory = require(packageFile(`@cornerstonejs/${packageName}/dist/${script}`))
  return (factory.default ?? factory)({ print: () => {}, printErr: () => {} })
}

function cornerstone(decoderName, codec) {
  return async stream => {
    const module = await codec
    const decoder = new module[decoderName]()
    try {
      decoder.getEncodedBuffer(stream.length).set(stream)
      decoder.decode()
      const { width, height, componentCount } = decoder.getFrameInfo()
      return [width, height, componentCount, Buffer.from(decoder.getDecodedBuffer())]
    } catch (problem) {
      throw typeof problem === 'number' && module.getExceptionMessage ? new Error(String(module.getExceptionMessage(problem))) : problem
    } finally {
      decoder.delete()
    }
  }
}

async function jsquash(part) {
  const meta = pathToFileURL(packageFile(`@jsquash/jpeg/${part}.js`))
  globalThis.ImageData ??= class { constructor(data, width, height) { Object.assign(this, { data, width, height }) } }
  const module = await import(meta)
  const wasm = packageFile(`@jsquash/jpeg/codec/${part.slice(0, 3)}/mozjpeg_${part.slice(0, 3)}.wasm`)
  await module.init(await WebAssembly.compile(fs.readFileSync(wasm)))
  return module.default
}

const CODECS = {
  'jpeg-js': () => {
    const jpeg = require('jpeg-js')
    return {
      decode(stream) {
        const { width, height, data } = jpeg.decode(stream, { useTArray: true })
        return [width, height, data.length / (width * height), data]
      },
      encode: (samples, width, height, quality) => jpeg.encode({ data: rgba(samples), width, height }, quality).data,
    }
  },
  sharp: () => {
    const sharp = require('sharp')
    return {
      async decode(stream) {
        const { data, info } = await sharp(stream).raw().toBuffer({ resolveWithObject: true })
        return [info.width, info.height, info.channels, data]
      },
      encode: (samples, width, height, quality) =>
        sharp(samples, { raw: { width, height, channels: 1 } }).jpeg({ quality }).toBuffer(),
    }
  },
  'sharp-b-w': () => {
    const sharp = require('sharp')
    return {
      async decode(stream) {
        const { data, info } = await sharp(stream).toColourspace('b-w').raw().toBuffer({ resolveWithObject: true })
        return [info.width, info.height, info.channels, data]
      },
      encode: (samples, width, height, quality) =>
        sharp(samples, { raw: { width, height, channels: 1 } }).toColourspace('b-w').jpeg({ quality }).toBuffer(),
    }
  },
  jsquash: async () => {
    const [decode, encode] = [await jsquash('decode'), await jsquash('encode')]
    return {
      async decode(stream) {
        const { width, height, data } = await decode(Uint8Array.from(stream).buffer)
        return [width, height, data.length / (width * height), data]
      },
      encode: async (samples, width, height, quality) =>
        Buffer.from(await encode({ data: new Uint8ClampedArray(rgba(samples)), width, height }, { quality })),
    }
  },
  'libjpeg-turbo-js': () => {
    const codec = emscripten('codec-libjpeg-turbo-8bit', 'libjpegturbojs.js')
    return { decode: cornerstone('JPEGDecoder', codec) }
  },
  'ls-charls-js': () => {
    const codec = emscripten('codec-charls', 'charlsjs.js')
    return {
      decode: cornerstone('JpegLSDecoder', codec),
      async encode(samples, width, height) {
        const encoder = new (await codec).JpegLSEncoder()
        try {
          encoder.getDecodedBuffer({ width, height, bitsPerSample: 8, componentCount: 1 }).set(samples)
          encoder.encode()
          return Buffer.from(encoder.getEncodedBuffer())
        } finally {
          encoder.delete()
        }
      },
    }
  },
}

const codec = await CODECS[name]()
let pending = Buffer.alloc(0)
for await (const part of process.stdin) {
  pending = Buffer.concat([pending, part])
  for (;;) {
    const end = pending.indexOf(10)
    if (end < 0) break
    const [request, ...numbers] = pending.subarray(0, end).toString().split(' ')
    const size = Number(numbers.at(-1))
    if (pending.length < end + 1 + size) break
    const body = pending.subarray(end + 1, end + 1 + size)
    pending = pending.subarray(end + 1 + size)
    let answer
    try {
      const [width, height, channels, data] = request === 'decode' ? await codec.decode(body)
        : [0, 0, 0, await codec.encode(body, ...numbers.slice(0, 3).map(Number))]
      answer = Buffer.concat([Buffer.from(`ok ${width} ${height} ${channels} ${data.length}\n`), Buffer.from(data)])
    } catch (problem) {
      answer = Buffer.from(`error ${String(problem?.message ?? problem).replace(/\s+/g, ' ').replace(/[^ -~]/g, '?').slice(0, 200)}\n`)
    }
    for (let sent = 0; sent < answer.length;) {
      try {
        sent += fs.writeSync(1, answer, sent)
      } catch (problem) {
        if (problem.code !== 'EAGAIN') throw problem
      }
    }
  }
}
process.exitCode = 0
