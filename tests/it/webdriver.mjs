// Drives a headless Chromium over WebDriver with only the modules of Node. Needs chromium and chromedriver.

import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

/** Starts a browser. `call` calls a method of its session, `run` runs a script in its page, and `close` ends it. */
export async function browser() {
  const profile = mkdtempSync(join(tmpdir(), "ptm-conform-browser-"));
  const driver = spawn("chromedriver", ["--port=0"], { stdio: ["ignore", "pipe", "ignore"] });
  const end = () => {
    driver.removeAllListeners("exit");
    driver.kill();
    rmSync(profile, { recursive: true, force: true, maxRetries: 10, retryDelay: 100 });
  };
  try {
    const port = await readPort(driver);
    const ask = async (method, path, body) => {
      const response = await fetch(`http://127.0.0.1:${port}${path}`, { method, body: body && JSON.stringify(body) });
      const { value } = await response.json();
      if (!response.ok) throw new Error(`${path}: ${value.error}: ${value.message}`);
      return value;
    };
    const { sessionId } = await ask("POST", "/session", { capabilities: { alwaysMatch: {
      browserName: "chrome",
      "goog:chromeOptions": {
        binary: "/usr/bin/chromium",
        args: ["--headless", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
          "--disable-component-update", "--disable-sync", "--hide-scrollbars", "--window-size=1280,1000", `--user-data-dir=${profile}`],
      },
      "goog:loggingPrefs": { browser: "ALL", performance: "ALL" },
    } } });
    const call = (method, path, body) => ask(method, `/session/${sessionId}${path}`, body);
    return {
      call,
      run: (script, ...args) => call("POST", "/execute/sync", { script, args }),
      close: async () => {
        await call("DELETE", "").catch(() => undefined);
        end();
      },
    };
  } catch (error) {
    end();
    throw error;
  }
}

function readPort(driver) {
  return new Promise((resolve, reject) => {
    let output = "";
    driver.stdout.on("data", (data) => {
      output += data;
      const match = /on port ([1-9]\d*)/.exec(output);
      if (match) resolve(match[1]);
    });
    driver.on("error", reject);
    driver.on("exit", () => reject(new Error(`chromedriver exited: ${output}`)));
    setTimeout(() => reject(new Error(`chromedriver printed no port: ${output}`)), 60_000).unref();
  });
}
