// The last frames as curves.
import uPlot from 'uplot';
import 'uplot/dist/uPlot.min.css';

export interface Sample { drawn: number; hidden: number; triangles: number; cullMs: number; drawMs: number }

const length = 240;
const colour = (name: string): string => getComputedStyle(document.documentElement).getPropertyValue('--' + name).trim();
const short = new Intl.NumberFormat('en', { notation: 'compact', maximumFractionDigits: 1 });

interface Line { label: string; colour: string; of: (sample: Sample) => number }
const plots: { title: string; lines: Line[]; format: (value: number) => string }[] = [
  { title: 'Objects in view', format: (v) => short.format(v), lines: [
    { label: 'drawn', colour: 'seen', of: (s) => s.drawn }, { label: 'hidden', colour: 'culled', of: (s) => s.hidden }] },
  { title: 'Triangles drawn', format: (v) => short.format(v), lines: [{ label: 'triangles', colour: 'series-1', of: (s) => s.triangles }] },
  { title: 'Milliseconds', format: (v) => (v < 10 ? v.toFixed(v < 1 ? 2 : 1) : v.toFixed(0)), lines: [
    { label: 'culling', colour: 'series-2', of: (s) => s.cullMs }, { label: 'drawing', colour: 'series-0', of: (s) => s.drawMs }] },
];

export class Charts {
  private readonly samples: Sample[] = [];
  private made: uPlot[] = [];
  private pending = 0;

  constructor(private readonly place: HTMLElement) {
    new ResizeObserver(() => this.fit()).observe(place);
  }

  push(sample: Sample): void {
    this.samples.push(sample);
    if (this.samples.length > length) this.samples.shift();
    if (!this.pending) this.pending = window.setTimeout(() => { this.pending = 0; this.draw(); }, 120);
  }

  clear(): void {
    this.samples.length = 0;
    this.draw();
  }

  /** Anew, in the colours of the theme. */
  rebuild(): void {
    for (const plot of this.made) plot.destroy();
    this.place.replaceChildren();
    this.made = plots.map(({ title, lines, format }) => {
      const figure = document.createElement('figure');
      const caption = document.createElement('figcaption');
      caption.append(title);
      for (const line of lines) {
        const key = document.createElement('span');
        key.className = 'key';
        key.style.setProperty('--key', colour(line.colour));
        key.textContent = line.label;
        if (lines.length > 1) caption.append(key);
      }
      figure.append(caption);
      this.place.append(figure);
      const muted = colour('muted');
      return new uPlot({
        width: Math.max(120, this.place.clientWidth), height: 74, legend: { show: false }, cursor: { show: false },
        padding: [6, 2, 2, 0],
        scales: { x: { time: false, range: [0, length - 1] }, y: { range: (_plot, _low, high) => [0, Math.max(high * 1.08, 1e-3)] } },
        axes: [{ show: false }, { size: 40, stroke: muted, font: '11px system-ui, "DejaVu Sans", sans-serif', gap: 4, space: 26,
          ticks: { show: false }, grid: { stroke: colour('line'), width: 1 }, values: (_plot, ticks) => ticks.map(format) }],
        series: [{}, ...lines.map((line) => ({ stroke: colour(line.colour), width: 1.75, points: { show: false } }))],
      }, this.data(lines), figure);
    });
  }

  private data(lines: Line[]): uPlot.AlignedData {
    return [this.samples.map((_, i) => length - this.samples.length + i), ...lines.map((line) => this.samples.map(line.of))] as uPlot.AlignedData;
  }
  private draw(): void { this.made.forEach((plot, i) => plot.setData(this.data(plots[i].lines))); }
  private fit(): void {
    const width = Math.max(120, this.place.clientWidth);
    for (const plot of this.made) if (plot.width !== width) plot.setSize({ width, height: 74 });
  }
}
