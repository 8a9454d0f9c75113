/// <reference types="vite/client" />
declare module '*.js?url' { const address: string; export default address; }
