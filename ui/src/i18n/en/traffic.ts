export const traffic = {
  title: 'Traffic',
};
