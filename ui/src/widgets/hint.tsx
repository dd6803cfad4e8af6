/** What a word means, where it stands: a mark that shows it on hover, by keyboard and by touch. */
export function Hint({ text }: { text: string }) {
  return (
    <button type="button" class="mark hint" aria-label={text}>
      ?
      <span class="tip" aria-hidden="true">
        {text}
      </span>
    </button>
  );
}
