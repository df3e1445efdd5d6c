!> The noise of the accelerometer in a case file or a setup: level and corner of its spectrum, or a table of amplitude spectral
!> densities. The table is read from a CSV file, and written as lists of numbers: a setup does not depend on other files.
module gracecg_observations_noise_table
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: AXES
    use gracecg_base_coloured_noise, only: noise_spectrum_t, ONE_SIDED, TWO_SIDED
    use gracecg_base_error, only: error_t, number_text
    use gracecg_base_text, only: integer_text
    use gracecg_files_file, only: text_file_t, read_text_file
    use gracecg_files_settings, only: settings_t
    use gracecg_files_table, only: table_file_t, csv_of_text
    implicit none
    private
    public :: describe_noise_spectra

    integer, parameter :: LEAST_ROWS = 4, MOST_ROWS = 1000
    real(dp), parameter :: LOWEST = 1e-9_dp, HIGHEST = 1e6_dp           !! Frequencies, Hz
    real(dp), parameter :: QUIETEST = 1e-20_dp, LOUDEST = 1.0_dp        !! Densities, m/s^2/sqrt(Hz)
    character(16), parameter :: COLUMNS(4) = [character(16) :: 'frequency_hz', 'ax_m_s2_sqrt_hz', 'ay_m_s2_sqrt_hz', &
                                              'az_m_s2_sqrt_hz']
    character(16), parameter :: COLUMNS_OF_ALL(2) = [character(16) :: 'frequency_hz', 'a_m_s2_sqrt_hz']

contains

    !> The noise spectra of the accelerometer's axes, within a group: level and corner, or a table in their place.
    subroutine describe_noise_spectra(settings, noise)
        class(settings_t), intent(inout) :: settings
        type(noise_spectrum_t), intent(inout) :: noise(3)   !! x, y, z; the sides of all are those of x

        real(dp) :: level(3), corner(3)     ! as arguments, noise%level and noise%corner are array temporaries

        level = noise%level
        corner = noise%corner
        if (.not. allocated(noise(1)%frequency)) then
            call settings%real_values('noise_level', level, 0.0_dp, 1.0_dp, 'm^2 s^-4/Hz', unit='m^2 s^-4/Hz')
            call settings%real_values('noise_corner', corner, 0.0_dp, 100.0_dp, 'Hz', unit='Hz')
            noise%level = level
            noise%corner = corner
        end if
        call describe_table(settings, noise)
        call settings%integer_value('noise_sides', noise(1)%sides, ONE_SIDED, TWO_SIDED, &
                                    'the spectrum is one- (1) or two-sided (2)')
        noise%sides = noise(1)%sides
    end subroutine describe_noise_spectra

    !> The table, where there is one: the key noise_table names its file, or the keys noise_frequency and noise_x, noise_y,
    !> noise_z hold it.
    subroutine describe_table(settings, noise)
        class(settings_t), intent(inout) :: settings
        type(noise_spectrum_t), intent(inout) :: noise(3)

        character(*), parameter :: KEYS(3) = ['noise_x', 'noise_y', 'noise_z']
        character(512) :: path
        real(dp), allocatable :: numbers(:, :), frequency(:), density(:)
        character(:), allocatable :: problem
        type(error_t), allocatable :: error
        logical :: is_table
        integer :: axis, row

        path = ''
        is_table = allocated(noise(1)%frequency)
        if (is_table) frequency = noise(1)%frequency
        if (.not. is_table) call settings%text_value('noise_table', path, 'CSV file of amplitude densities over frequency, '// &
                                                     'in place of level and corner; empty: none')
        if (path /= '') then
            call read_noise_table(trim(path), numbers, error)
            if (allocated(error)) then
                if (.not. allocated(settings%failure)) call move_alloc(error, settings%failure)
                return
            end if
            call take_table(numbers, noise)
            return
        end if
        call settings%real_list('noise_frequency', frequency, LOWEST, HIGHEST, 'of the table', 'Hz')
        if (.not. allocated(frequency)) return
        allocate (numbers(size(frequency), 4))
        numbers(:, 1) = frequency
        do axis = 1, 3
            if (is_table) density = sqrt(noise(axis)%level*noise(axis)%shape)
            call settings%real_list(KEYS(axis), density, QUIETEST, LOUDEST, 'amplitude densities', 'm/s^2/sqrt(Hz)')
            if (allocated(settings%failure)) return
            if (.not. allocated(density)) allocate (density(0))
            if (size(density) /= size(frequency)) then
                call settings%reject('noise_frequency', integer_text(size(frequency))//' frequencies, but '// &
                                     integer_text(size(density))//' values of '//KEYS(axis)//'; it must be as many')
                return
            end if
            numbers(:, 1 + axis) = density
            deallocate (density)
        end do
        call find_problem(frequency, row, problem)
        if (allocated(problem)) then
            call settings%reject('noise_frequency', problem, row)
            return
        end if
        if (.not. is_table) call take_table(numbers, noise)
    end subroutine describe_table

    !> Reads a file: frequency, then a density for all axes or one for each. Fails when it cannot be read, a number is not in
    !> its range, or the frequencies do not increase.
    subroutine read_noise_table(path, numbers, error)
        character(*), intent(in) :: path
        real(dp), allocatable, intent(out) :: numbers(:, :)     !! Hz, m/s^2/sqrt(Hz) of x, y, z: (rows, 4)
        type(error_t), allocatable, intent(out) :: error

        type(text_file_t) :: text
        type(table_file_t) :: file
        real(dp), allocatable :: found(:, :)
        character(:), allocatable :: problem
        character(16), allocatable :: names(:)
        integer :: row, column

        call read_text_file(path, text, error)
        if (allocated(error)) return
        names = COLUMNS
        if (index(text%text, trim(COLUMNS_OF_ALL(2))) > 0) names = COLUMNS_OF_ALL
        call csv_of_text(text, names, file, error)
        call file%get_numbers(names, found, error)
        if (allocated(error)) return
        numbers = found(:, [1, (min(1 + column, size(names)), column=1, 3)])
        do row = 1, size(numbers, 1)
            if (.not. (numbers(row, 1) >= LOWEST .and. numbers(row, 1) <= HIGHEST)) problem = 'frequency_hz = '// &
                number_text(numbers(row, 1))//'; it must be from '//number_text(LOWEST)//' to '//number_text(HIGHEST)//' Hz'
            do column = 2, 4
                if (numbers(row, column) >= QUIETEST .and. numbers(row, column) <= LOUDEST) cycle
                problem = 'amplitude density of '//AXES(column - 1)//' = '//number_text(numbers(row, column))// &
                          '; it must be from '//number_text(QUIETEST)//' to '//number_text(LOUDEST)//' m/s^2/sqrt(Hz)'
                exit
            end do
            if (allocated(problem)) exit
        end do
        if (.not. allocated(problem)) call find_problem(numbers(:, 1), row, problem)
        if (allocated(problem)) call file%fail_at(row, problem, error)
    end subroutine read_noise_table

    !> The first frequency with which something is wrong.
    pure subroutine find_problem(frequency, row, problem)
        real(dp), intent(in) :: frequency(:)                    !! Hz
        integer, intent(out) :: row
        character(:), allocatable, intent(out) :: problem       !! Not allocated: all is well

        integer :: i

        associate (n => size(frequency))
            row = findloc([(frequency(i) > frequency(i - 1), i=2, n)], .false., 1) + 1
            if (row > 1) then
                problem = 'the frequency '//number_text(frequency(row))//' Hz stands behind '// &
                          number_text(frequency(row - 1))//' Hz; frequencies must increase'
                return
            end if
            row = n
            if (n < LEAST_ROWS .or. n > MOST_ROWS) problem = 'the table of the noise has '//integer_text(n)//' rows; it '// &
                'must have from '//integer_text(LEAST_ROWS)//' to '//integer_text(MOST_ROWS)
        end associate
    end subroutine find_problem

    !> The spectra of a table. The level is the least density of an axis.
    pure subroutine take_table(numbers, noise)
        real(dp), intent(in) :: numbers(:, :)                   !! (rows, 4)
        type(noise_spectrum_t), intent(inout) :: noise(3)

        integer :: axis

        do axis = 1, 3
            noise(axis)%level = minval(numbers(:, 1 + axis))**2
            noise(axis)%corner = 0
            noise(axis)%frequency = numbers(:, 1)
            noise(axis)%shape = numbers(:, 1 + axis)**2/noise(axis)%level
        end do
    end subroutine take_table
end module gracecg_observations_noise_table
