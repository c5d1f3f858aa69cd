// Says what a library takes files for: identify.mjs FOLDER LIBRARY FILE... prints a JSON list with one string per file. FOLDER has node_modules.
import { createRequire } from 'node:module'
import fs from 'node:fs'
import path from 'node:path'
import { pathToFileURL } from 'node:url'

const [folder, library, ...files] = process.argv.slice(2)
const require = createRequire(path.join(folder, 'package.json'))
const load = (name) => import(pathToFileURL(require.resolve(name)))

const libraries = {
  async 'file-type' (bytes) {
    const found = await (await load('file-type')).fileTypeFromBuffer(bytes)
    return found?.mime
  },
  async 'magic-bytes.js' (bytes) {
    const module = await load('magic-bytes.js')
    const found = (module.filetypeinfo ?? module.default.filetypeinfo)(bytes)
    return found.map((one) => one.typename).join(', ')
  }
}
const results = []
for (const file of files) results.push(await libraries[library](fs.readFileSync(file)) || 'nothing')
console.log(JSON.stringify(results))
