/* A page from a folder may start no worker, which the search runs in: there a frame that nobody sees
   runs the worker's script. It shares the origin of the page. */
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      const frame = document.createElement("iframe");
      frame.hidden = true;
      this.started = new Promise((done) => { frame.onload = () => done(frame.contentWindow); });
      frame.srcdoc = "<!DOCTYPE html><title>search</title>";
      document.documentElement.append(frame);
      this.ready = this.started.then((inner) => new Promise((done) => {
        inner.postMessage = (data) => this.dispatchEvent(new MessageEvent("message", { data }));
        const script = inner.document.createElement("script");
        script.src = url;
        script.onload = () => done(inner);
        inner.document.head.append(script);
      }));
    }

    postMessage(data) {
      this.ready.then((inner) => inner.dispatchEvent(new MessageEvent("message", { data })));
    }
  };
}
