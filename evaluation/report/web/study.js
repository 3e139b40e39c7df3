// A user study: pairs of portraits, blind, and the choices as a file. evaluation/study/study.cpp writes the pictures.

/// `items` in an order of chance.
function shuffled(items) {
  const mixed = [...items];
  for (let i = mixed.length - 1; i > 0; --i) {
    const other = Math.floor(Math.random() * (i + 1));
    [mixed[i], mixed[other]] = [mixed[other], mixed[i]];
  }
  return mixed;
}

class StudyPage {
  constructor(stage, {study, scenes}) {
    this.stage = stage;
    this.study = study;
    this.scenes = scenes;
    this.order = shuffled(scenes.keys());
    this.votes = [];
    this.choose = null;  // what the arrow keys call
    document.addEventListener('keydown', event => {
      const side = {ArrowLeft: 0, ArrowRight: 1}[event.key];
      const combined = event.altKey || event.ctrlKey || event.metaKey;  // the browser's own, such as 'back'
      if (side === undefined || !this.choose || event.repeat || combined) return;
      event.preventDefault();
      this.choose(side);
    });
    this.showStart();
  }

  showStart() {
    const name = element('input', {id: 'participant', required: '', maxlength: 40});
    const start = () => {
      this.participant = name.value.trim();
      if (this.participant) this.nextScene();
      else name.focus();
    };
    this.stage.replaceChildren(
        element('p', {}, `You will see two pictures of one scene, ${this.scenes.length} scenes in all. Choose the one ` +
                         'that you would rather have from your own camera. Below each are parts of it, enlarged.'),
        element('p', {}, 'Click on a picture, or press ← or →. At the end, save your choices as a file.'),
        element('p', {}, element('label', {for: 'participant'}, 'Your name or letter '), name, ' ',
                element('button', {onclick: start}, 'Start')));
    name.addEventListener('keydown', event => event.key === 'Enter' && start());
    name.focus();
  }

  nextScene() {
    if (this.votes.length === this.order.length) return this.showEnd();
    const scene = this.order[this.votes.length];
    this.waiting = shuffled(this.scenes[scene].keys());
    this.vote = {scene, comparisons: []};
    this.best = this.waiting.pop();
    this.nextPair();
  }

  /// The one that is preferred so far and another, on sides of chance.
  nextPair() {
    const pair = shuffled([this.best, this.waiting.pop()]);
    this.choose = side => {
      this.choose = null;
      this.best = pair[side];
      this.vote.comparisons.push([...pair, this.best]);
      if (this.waiting.length) return this.nextPair();
      this.votes.push(this.vote);
      this.nextScene();
    };
    const pictures = this.scenes[this.vote.scene];
    this.stage.replaceChildren(
        element('p', {class: 'soft', 'aria-live': 'polite'},
                `Scene ${this.votes.length + 1} of ${this.order.length}, pair ${this.vote.comparisons.length + 1} of ` +
                `${pictures.length - 1}`),
        element('div', {class: 'pair'}, ...pair.map((picture, side) => this.choice(pictures[picture], side))));
    window.scrollTo(0, 0);
  }

  choice({whole, crops}, side) {
    const name = ['left', 'right'][side];
    return element('button', {class: 'choice', 'aria-label': `Prefer the ${name} picture`,
                              // a double click is one choice
                              onclick: event => event.detail > 1 || this.choose?.(side)},
                   element('img', {src: whole, alt: `The ${name} picture`}),
                   element('span', {class: 'crops'},
                           ...crops.map((src, i) => element('img', {src, alt: `Part ${i + 1}, ${name}`}))));
  }

  showEnd() {
    const text = JSON.stringify({format: 'dualpixel votes', version: 1, study: this.study,
                                 participant: this.participant, scenes: this.votes}) + '\n';
    const url = URL.createObjectURL(new Blob([text], {type: 'application/json'}));
    const file = `votes_${this.participant.replace(/[^\w-]+/g, '_')}.json`;
    this.stage.replaceChildren(
        element('p', {}, 'That was all: thank you.'),
        element('p', {}, element('a', {href: url, download: file, id: 'save'}, `Save ${file}`),
                ', or copy this text into a file:'),
        element('pre', {}, text));
  }
}

new StudyPage(document.getElementById('study'),
              JSON.parse(document.querySelector('script[type="application/json"]').textContent));
