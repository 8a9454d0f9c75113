const CODES = ["ok", "usage", "io", "corrupt", "unsupported", "limit", "mismatch", "cancelled", "internal"];

/** What goes wrong: `code` is one of the words of ant_status_name, the message names the place and the cure. */
export class AntumbraError extends Error {
  constructor(code, message, options) {
    super(message, options);
    this.name = "AntumbraError";
    this.code = code;
  }
}

export function codeOf(status) {
  return CODES[status] ?? "internal";
}
