!> The CSV files of the studies: curves of a case, places of the orbit, gravity gradient, error sources,
!> and the field model in place of the magnetometer.
module gracecg_studies_study_files
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, MILLIMETRE, NANOTESLA, AXES
    use gracecg_base_error, only: error_t
    use gracecg_base_version, only: VERSION
    use gracecg_base_text, only: integer_text, real_text
    use gracecg_files_csv, only: csv_writer_t
    use gracecg_studies_curves, only: verification_t, CURVE_NAMES
    use gracecg_planning_scan, only: orbit_place_t
    use gracecg_studies_gravity_gradient, only: gradient_sample_t
    use gracecg_studies_error_sources, only: error_study_t, STUDY_NAMES
    use gracecg_studies_magnetometer_loss, only: field_study_t, FIELD_SOURCES
    implicit none
    private
    public :: write_curves, write_places, write_gradient, write_error_sources, write_field_studies, &
        write_field_runs, curves_file_name

    integer, parameter :: COMMENT_LENGTH = 160
    character(*), parameter :: PREFIX = 'verify_', SUFFIX = '.csv'  !! Of the files of curves

contains

    !> verify_CASE.csv, an underscore for everything unusual in the case's name.
    pure function curves_file_name(case_name) result(name)
        character(*), intent(in) :: case_name    !! Any
        character(len(PREFIX) + len_trim(case_name) + len(SUFFIX)) :: name

        integer :: i

        name = PREFIX//trim(case_name)//SUFFIX
        do i = 1, len(name)
            select case (name(i:i))
            case ('a':'z', 'A':'Z', '0':'9', '-', '.', '_')
            case default
                name(i:i) = '_'
            end select
        end do
    end function curves_file_name

    !> The curves of Figures 5.2-5.8 of a case.
    subroutine write_curves(path, command, case_name, verification, error)
        character(*), intent(in) :: path    !! The file
        character(*), intent(in) :: command         !! That computed them, for the comments
        character(*), intent(in) :: case_name    !! For the comments
        type(verification_t), intent(in) :: verification
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        character(:), allocatable :: header
        integer :: curve, axis, k

        header = 'time_s'
        do curve = 1, size(CURVE_NAMES)
            do axis = 1, size(AXES)
                header = header//','//trim(CURVE_NAMES(curve))//'_'//AXES(axis)
            end do
        end do
        call file%open(path, header, comments_of(command, 'case '//trim(case_name)// &
                                                 '; m/s^2, N m, rad/s, rad/s^2, body axes'), error)
        if (allocated(error)) return
        do k = lbound(verification%time, 1), ubound(verification%time, 1)
            call file%row([verification%time(k), verification%curve(:, :, k)])
        end do
        call file%commit(error)
    end subroutine write_curves

    !> Figures 6.1 and 6.4: the calibrations at the places of an orbit.
    subroutine write_places(path, command, satellite, places, error)
        character(*), intent(in) :: path, command, satellite
        !! The file; the command that computed it, and the satellite, for the comments
        type(orbit_place_t), intent(in) :: places(:)
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        integer :: i

        call file%open(path, 'time_s,latitude_deg,longitude_deg,bx_nt,by_nt,bz_nt,alpha_x,alpha_y,alpha_z,'// &
                       'sigma_x_mm,sigma_y_mm,sigma_z_mm', &
                       comments_of(command, trim(satellite)//' satellite; field in body axes; alpha in rad/s^2'), &
                       error)
        if (allocated(error)) return
        do i = 1, size(places)
            associate (place => places(i))
                call file%row([real(place%time, dp), place%latitude/DEGREE, place%longitude/DEGREE, &
                               place%field/NANOTESLA, place%acceleration, place%sigma/MILLIMETRE])
            end associate
        end do
        call file%commit(error)
    end subroutine write_places

    !> Figure 3.1: the gravity gradient along an orbit.
    subroutine write_gradient(path, command, settings, samples, error)
        character(*), intent(in) :: path, command
        !! The file; the command that computed it, for the comments
        character(*), intent(in) :: settings        !! Of the study, for the comments
        type(gradient_sample_t), intent(in) :: samples(:)
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        integer :: i

        call file%open(path, 'time_s,central_r,central_t,central_n,others_r,others_t,others_n', &
                       comments_of(command, settings//'; m/s^2; radial, transverse, normal'), error)
        if (allocated(error)) return
        do i = 1, size(samples)
            call file%row([samples(i)%time, samples(i)%central, samples(i)%others])
        end do
        call file%commit(error)
    end subroutine write_gradient

    !> Figure 6.5: RMS errors with one error source off at a time.
    subroutine write_error_sources(path, command, settings, studies, error)
        character(*), intent(in) :: path, command, settings
        !! The file; the command that computed it, and its settings, for the comments
        type(error_study_t), intent(in) :: studies(:)       !! In the order of STUDY_NAMES
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        integer :: i, axis

        call file%open(path, 'source,axis,runs,rms_mm', comments_of(command, settings), error)
        if (allocated(error)) return
        do i = 1, size(studies)
            do axis = 1, 3
                call file%row([real(studies(i)%runs, dp), studies(i)%rms(axis)/MILLIMETRE], &
                              [character(12) :: STUDY_NAMES(i), AXES(axis)])
            end do
        end do
        call file%commit(error)
    end subroutine write_error_sources

    !> Figure 6.6: RMS errors with measured and with modelled field.
    subroutine write_field_studies(path, command, seed, deviation, studies, error)
        character(*), intent(in) :: path, command
        !! The file; the command that computed it, for the comments
        integer, intent(in) :: seed    !! Of the runs
        real(dp), intent(in) :: deviation           !! Of the model's error, T
        type(field_study_t), intent(in) :: studies(:)
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        character(64) :: labels(4)
        integer :: i, axis

        call file%open(path, 'case,algorithm,magnetometer,axis,runs,rms_mm', &
                       field_comments(command, seed, deviation), error)
        if (allocated(error)) return
        do i = 1, size(studies)
            labels(:3) = labels_of(studies(i))
            do axis = 1, 3
                labels(4) = AXES(axis)
                call file%row([real(size(studies(i)%run), dp), studies(i)%rms(axis)/MILLIMETRE], labels)
            end do
        end do
        call file%commit(error)
    end subroutine write_field_studies

    !> The estimates of every run with measured and with modelled field.
    subroutine write_field_runs(path, command, seed, deviation, studies, error)
        character(*), intent(in) :: path, command
        !! The file; the command that computed it, for the comments
        integer, intent(in) :: seed    !! Of the runs
        real(dp), intent(in) :: deviation           !! Of the model's error, T
        type(field_study_t), intent(in) :: studies(:)
        type(error_t), allocatable, intent(out) :: error

        type(csv_writer_t) :: file
        integer :: i, k

        call file%open(path, 'case,algorithm,magnetometer,run,dx_mm,dy_mm,dz_mm', &
                       field_comments(command, seed, deviation), error)
        if (allocated(error)) return
        do i = 1, size(studies)
            do k = 1, size(studies(i)%run)
                call file%row([real(studies(i)%run(k), dp), studies(i)%offset(:, k)/MILLIMETRE], &
                              labels_of(studies(i)))
            end do
        end do
        call file%commit(error)
    end subroutine write_field_runs

    pure function labels_of(study) result(labels)
        type(field_study_t), intent(in) :: study
        character(64) :: labels(3)

        labels(1) = study%case_name
        labels(2) = study%algorithm
        labels(3) = FIELD_SOURCES(merge(2, 1, study%with_model))
    end function labels_of

    function field_comments(command, seed, deviation) result(comments)
        character(*), intent(in) :: command
        integer, intent(in) :: seed
        real(dp), intent(in) :: deviation           !! T
        character(COMMENT_LENGTH) :: comments(2)

        comments = comments_of(command, 'seed '//integer_text(seed)//', error of the field model '// &
                               real_text(anint(deviation/NANOTESLA*1e6_dp)/1e6_dp)//' nT')
    end function field_comments

    pure function comments_of(command, settings) result(comments)
        character(*), intent(in) :: command, settings
        character(COMMENT_LENGTH) :: comments(2)

        comments(1) = 'gracecg '//VERSION//' '//command
        comments(2) = settings
    end function comments_of
end module gracecg_studies_study_files
