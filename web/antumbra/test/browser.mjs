// Debian's chromium, and a server for its pages.
import { existsSync, readFileSync, statSync } from "node:fs";
import { createServer } from "node:http";
import { extname } from "node:path";
import { chromium } from "playwright-core";

const TYPES = { ".js": "text/javascript", ".mjs": "text/javascript", ".html": "text/html", ".json": "application/json" };
export const chromiumPath = ["/usr/bin/chromium", "/usr/bin/chromium-browser"].find((path) => existsSync(path));

/** `pages`: path to html (or {body, headers, type}); `folders`: path prefix to folder. */
export async function serve(pages, folders) {
  const server = createServer((request, response) => {
    const path = decodeURIComponent(new URL(request.url, "http://x").pathname);
    const page = pages[path];
    if (page !== undefined) {
      const { body = page, headers = {}, type = TYPES[extname(path)] ?? "text/html" } = typeof page === "string" ? {} : page;
      response.writeHead(200, { "content-type": type, ...headers }).end(body);
      return;
    }
    for (const [prefix, folder] of Object.entries(folders)) {
      const file = path.startsWith(prefix) && !path.includes("..") ? `${folder}/${path.slice(prefix.length)}` : "";
      if (file && existsSync(file) && statSync(file).isFile()) {
        response.writeHead(200, { "content-type": TYPES[extname(file)] ?? "application/octet-stream" }).end(readFileSync(file));
        return;
      }
    }
    response.writeHead(path === "/favicon.ico" ? 204 : 404).end();
  });
  await new Promise((resolve) => server.listen(0, "127.0.0.1", resolve));
  return { url: `http://127.0.0.1:${server.address().port}`, close: () => server.close() };
}

export async function launch() {
  return chromium.launch({
    executablePath: chromiumPath,
    args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"],
  });
}

/** Opens a page and calls its window.run(...args), which it must define; gives what that returns and what was said on the console. */
export async function runPage(browser, url, ...args) {
  const page = await browser.newPage({ viewport: { width: 480, height: 320 } });
  const said = [];
  page.on("console", (message) => ["error", "warning"].includes(message.type()) && said.push(message.text()));
  page.on("pageerror", (error) => said.push(String(error)));
  await page.goto(url);
  await page.waitForFunction(() => typeof window.run === "function", null, { timeout: 30000 });
  const result = await page.evaluate((list) => window.run(...list), args);
  await page.close();
  return { result, said };
}
