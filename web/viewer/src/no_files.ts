// A browser has no file system; the package asks for one only in node.
export const readFile = (): Promise<never> => Promise.reject(new Error('a page cannot read files by name'));
