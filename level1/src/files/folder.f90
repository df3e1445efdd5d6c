!> The Level-1 files of a folder, by product, satellite and day, as their names say.
module gracecg_level1_folder
    use gracecg_base_error, only: error_t, fail
    use gracecg_base_text, only: string_t, append, integer_text
    use gracecg_environment_time, only: utc_t, parse_utc
    use gracecg_files_file, only: is_unfinished
    use gracecg_files_folder, only: files_in_folder
    use gracecg_level1_header, only: product_of_file_name, satellite_of_file_name, date_of_file_name
    use gracecg_level1_products, only: SATELLITES, is_calibration_history
    implicit none
    private
    public :: level1_folder_t, open_level1_folder

    type :: level1_folder_t
        !! The files of one satellite, of one day or several, and the calibration histories
        character(:), allocatable :: folder    !! As the user gave it
        character(1) :: satellite = ''                  !! A to D
        character(10) :: date = ''                      !! YYYY-MM-DD of the names: the first day, or the one asked for
        character(10), allocatable :: days(:)           !! All days that are joined, in order
        type(string_t), allocatable :: paths(:)         !! Of all files of the satellite, by name
        type(string_t), allocatable :: warnings(:)      !! What was passed over
    contains
        procedure :: path_of                            !! The file of a product on `date`
        procedure :: paths_of                           !! The files of a product on all days
    end type level1_folder_t

contains

    !> Looks what is there. Without a satellite it is the first one that has files. All days that it has files of belong
    !> together; with a day that one, the one before and the one behind, for a manoeuvre may begin or end there. Fails when
    !> there is no Level-1 file of the satellite, or of that day.
    subroutine open_level1_folder(folder, satellite, files, error, day)
        character(*), intent(in) :: folder              !! With or without a slash at the end
        character(1), intent(in) :: satellite           !! A to D; blank: the first one
        type(level1_folder_t), intent(out) :: files
        type(error_t), allocatable, intent(out) :: error
        character(*), intent(in), optional :: day       !! YYYY-MM-DD; blank: all

        type(string_t), allocatable :: found(:)
        character(:), allocatable :: others
        character(10) :: wanted, date
        character(5) :: product
        character(1) :: letter
        integer :: i, number

        files%folder = trim(folder)
        allocate (files%paths(0), files%warnings(0), files%days(0))
        wanted = ''
        if (present(day)) wanted = day
        number = day_number(wanted)
        if (wanted /= '') then
            if (number == 0 .or. len_trim(day) /= len(wanted)) then
                call fail(error, '"'//trim(day)//'" is no date; a day is given like 2020-02-01')
                return
            end if
        end if
        call files_in_folder(folder, found, error)
        if (allocated(error)) return
        files%satellite = satellite
        others = ''
        do i = 1, size(found)
            if (product_of_file_name(found(i)%text) == '' .or. .not. is_unfinished(found(i)%text)) cycle
            call append(files%warnings, found(i)%text//' is left out: it is what is left of a program that was ended while '// &
                        'it wrote')
            found(i)%text = ''
        end do
        do i = 1, size(found)
            product = product_of_file_name(found(i)%text)
            letter = satellite_of_file_name(found(i)%text)
            if (product == '' .or. is_calibration_history(product) .or. scan(letter, SATELLITES) == 0) cycle
            if (files%satellite == '') files%satellite = letter
            if (letter /= files%satellite .and. index(others, letter) == 0) others = others//' '//letter
        end do
        do i = 1, size(found)
            product = product_of_file_name(found(i)%text)
            if (product == '' .or. satellite_of_file_name(found(i)%text) /= files%satellite) cycle
            if (.not. is_calibration_history(product)) then
                date = date_of_file_name(found(i)%text)
                if (number /= 0 .and. abs(day_number(date) - number) > 1) cycle
                call add_day(files%days, date)
            end if
            call append(files%paths, found(i)%text)
        end do
        if (size(files%days) > 0) files%date = files%days(1)
        if (wanted /= '' .and. any(files%days == wanted)) files%date = wanted
        if (size(files%days) == 0 .or. (wanted /= '' .and. files%date /= wanted)) then
            others = ''
            if (satellite /= '') others = ' of satellite '//satellite
            if (wanted /= '') others = others//' of '//wanted
            call fail(error, trim(folder)//': no Level-1 files'//others//'; their names are like '// &
                      'ACC1A_2023-06-01_C_04.txt')
            return
        end if
        if (others /= '' .and. satellite == '') &
            call append(files%warnings, 'the folder has files of satellites '//files%satellite//others//': '// &
                        files%satellite//' is taken')
        call tell_days(files)
    end subroutine open_level1_folder

    !> Adds a day where it belongs; one that is there already is not added again.
    subroutine add_day(days, date)
        character(10), allocatable, intent(inout) :: days(:)
        character(10), intent(in) :: date

        character(10) :: more(size(days) + 1)
        integer :: earlier

        if (any(days == date)) return
        earlier = count(days < date)
        more(:earlier) = days(:earlier)
        more(earlier + 1) = date
        more(earlier + 2:) = days(earlier + 1:)
        days = more
    end subroutine add_day

    !> That days are joined, and whether days between them are missing.
    subroutine tell_days(files)
        type(level1_folder_t), intent(inout) :: files

        character(:), allocatable :: text
        integer :: n, missing

        n = size(files%days)
        if (n < 2) return
        text = 'files of '//integer_text(n)//' days are joined, '//files%days(1)//' to '//files%days(n)
        missing = day_number(files%days(n)) - day_number(files%days(1)) + 1 - n
        if (missing > 0) text = text//' ('//integer_text(missing)//' between are missing)'
        call append(files%warnings, text)
    end subroutine tell_days

    !> The modified Julian day of a date YYYY-MM-DD; 0 when it is none.
    integer function day_number(date) result(number)
        character(10), intent(in) :: date

        type(utc_t) :: utc
        type(error_t), allocatable :: error

        call parse_utc(date, utc, error)
        number = merge(0, utc%mjd, allocated(error))
    end function day_number

    !> The file of a product on `date`, text before binary (by name the last); of a history the last one of all. Empty
    !> when there is none.
    subroutine path_of(self, product, path)
        class(level1_folder_t), intent(in) :: self
        character(5), intent(in) :: product         !! 'ACC1A'
        character(:), allocatable, intent(out) :: path    !! Empty when there is none

        call last_path(self, product, self%date, path)
    end subroutine path_of

    !> The files of a product on all days, in order; none where there is none.
    subroutine paths_of(self, product, paths)
        class(level1_folder_t), intent(in) :: self
        character(5), intent(in) :: product         !! 'ACC1A'
        type(string_t), allocatable, intent(out) :: paths(:)    !! One of each day that has one; of a history the last one

        character(:), allocatable :: path
        integer :: i

        allocate (paths(0))
        do i = 1, size(self%days)
            call last_path(self, product, self%days(i), path)
            if (path == '') cycle
            call append(paths, path)
            if (is_calibration_history(product)) return
        end do
    end subroutine paths_of

    !> The last file by name of a product and a date; of a history of any date.
    subroutine last_path(self, product, date, path)
        class(level1_folder_t), intent(in) :: self
        character(5), intent(in) :: product
        character(10), intent(in) :: date
        character(:), allocatable, intent(out) :: path

        integer :: i

        path = ''
        do i = 1, size(self%paths)
            if (product_of_file_name(self%paths(i)%text) /= product) cycle
            if (date_of_file_name(self%paths(i)%text) /= date .and. .not. is_calibration_history(product)) cycle
            path = self%paths(i)%text
        end do
    end subroutine last_path
end module gracecg_level1_folder
