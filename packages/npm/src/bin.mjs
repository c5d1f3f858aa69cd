#!/usr/bin/env node
// Runs the program ptm-conform.

import { spawnSync } from "node:child_process";

import { program } from "./node.mjs";

const { status, error } = spawnSync(program(), process.argv.slice(2), { stdio: "inherit" });
if (error) throw error;
process.exitCode = status ?? 1;
