// A headless Chromium, driven over WebDriver by nothing but what node has. Needs chromium and chromedriver.

import { spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

/** Starts a browser: `call` a method of its session, `run` a script in its page, `close` it. */
export async function browser() {
  const profile = mkdtempSync(join(tmpdir(), "ptm-conform-browser-"));
  const driver = spawn("chromedriver", ["--port=0"], { stdio: ["ignore", "pipe", "ignore"] });
  const end = () => {
    driver.removeAllListeners("exit");
    driver.kill();
    rmSync(profile, { recursive: true, force: true, maxRetries: 10, retryDelay: 100 });
  };
  try {
    const port = await portOf(driver);
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

function portOf(driver) {
  return new Promise((resolve, reject) => {
    let said = "";
    driver.stdout.on("data", (data) => {
      said += data;
      const match = /on port ([1-9]\d*)/.exec(said);
      if (match) resolve(match[1]);
    });
    driver.on("error", reject);
    driver.on("exit", () => reject(new Error(`chromedriver ended: ${said}`)));
    setTimeout(() => reject(new Error(`chromedriver says no port: ${said}`)), 60_000).unref();
  });
}
