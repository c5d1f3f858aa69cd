// Reads one file with one library: read.mjs FOLDER LIBRARY FILE OUT. FOLDER has node_modules; OUT gets the description in JSON, and OUT.raw the samples.
import { createRequire } from 'node:module'
import fs from 'node:fs'
import path from 'node:path'
import { pathToFileURL } from 'node:url'

const [folder, library, file, out] = process.argv.slice(2)
const require = createRequire(path.join(folder, 'package.json'))
const load = (name) => import(pathToFileURL(require.resolve(name)))
const bytes = fs.readFileSync(file)
const buffer = bytes.buffer.slice(bytes.byteOffset, bytes.byteOffset + bytes.length)
const importFile = (name) => import(pathToFileURL(path.join(folder, 'node_modules', name)))
const TYPES = { Float32Array: '<f4', Uint16Array: '<u2', Uint8Array: 'u1', Uint8ClampedArray: 'u1', Buffer: 'u1' }

const libraries = {
  async three () {
    const { EXRLoader } = await importFile('three/examples/jsm/loaders/EXRLoader.js')
    const { FloatType } = await importFile('three/build/three.module.js')
    const loader = new EXRLoader().setDataType(FloatType)
    const { data, width, height } = loader.parse(buffer)
    return { data, width, height }
  },
  async 'parse-exr' () {
    const { default: parse } = await load('parse-exr')
    const { data, width, height } = parse(buffer, 1015) // 1015 is the number of FloatType in three
    return { data, width, height }
  },
  async npyjs () {
    const { parse } = await load('npyjs')
    const { data, shape } = parse(buffer)
    return { data, width: shape[1], height: shape[0] }
  },
  async sharp () {
    const { default: sharp } = await load('sharp')
    const { data, info } = await sharp(bytes).raw().toBuffer({ resolveWithObject: true })
    return { data, width: info.width, height: info.height }
  },
  async pngjs () {
    const { PNG } = await load('pngjs')
    return PNG.sync.read(bytes)
  },
  async 'fast-png' () {
    const { decode } = await load('fast-png')
    return decode(bytes)
  }
}

let head
try {
  const { data, width, height } = await libraries[library]()
  head = { width, height, channels: data.length / width / height, type: TYPES[data.constructor.name] }
  fs.writeFileSync(out + '.raw', Buffer.from(data.buffer, data.byteOffset, data.byteLength))
} catch (error) {
  head = { error: String(error.message).split('\n')[0] }
}
fs.writeFileSync(out, JSON.stringify(head))
