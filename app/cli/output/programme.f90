!> Programmes of several manoeuvres, as `timing` and `design` print them.
module gracecg_cli_programme
    use gracecg_base_kinds, only: dp
    use gracecg_base_constants, only: DEGREE, MILLIMETRE
    use gracecg_base_text, only: integer_text, rounded_text
    use gracecg_files_data_table, only: data_table_t
    use gracecg_files_json, only: json_writer_t
    use gracecg_planning_programme, only: candidate_t, programme_t
    use gracecg_cli_console, only: console_t
    implicit none
    private
    public :: show_programme, put_programme

contains

    !> For people.
    subroutine show_programme(candidates, programme, wanted, console)
        type(candidate_t), intent(in) :: candidates(:)
        type(programme_t), intent(in) :: programme
        real(dp), intent(in) :: wanted      !! Of the largest sigma, m; 0: nothing was asked for
        type(console_t), intent(inout) :: console

        character(:), allocatable :: line

        associate (n => size(programme%chosen), reached => maxval(programme%sigma(:, size(programme%chosen))))
            line = 'programme of '//integer_text(n)//' manoeuvre'//trim(merge('s', ' ', n > 1))//', in the order of flight'
            if (wanted > 0) line = line//': largest sigma '//rounded_text(reached/MILLIMETRE, 3)//' mm, wanted '// &
                                   rounded_text(wanted/MILLIMETRE, 3)//' mm'// &
                                   trim(merge(': not reached', '             ', reached > wanted))
        end associate
        call console%line('')
        call console%line(line)
        call console%table(table_of(candidates, programme))
        call console%line('(sigma of all manoeuvres up to this one together, by information)')
    end subroutine show_programme

    !> As a member of an object.
    subroutine put_programme(candidates, programme, writer)
        type(candidate_t), intent(in) :: candidates(:)
        type(programme_t), intent(in) :: programme
        class(json_writer_t), intent(inout) :: writer

        type(data_table_t) :: table

        table = table_of(candidates, programme)
        call table%to_json(writer, 'programme')
    end subroutine put_programme

    function table_of(candidates, programme) result(table)
        type(candidate_t), intent(in) :: candidates(:)
        type(programme_t), intent(in) :: programme
        type(data_table_t) :: table

        real(dp), parameter :: UNSEEN = 1e3_dp      ! m: beyond, a direction is not seen yet
        integer :: i, axis

        call table%column('time_s', 'i8', 'time|s')
        call table%column('duration_s', 'f8.1', 'length|s')
        call table%column('latitude_deg', 'f8.1', 'lat.|deg')
        call table%column('longitude_deg', 'f8.1', 'long.|deg')
        call table%column('sigma_x_mm', 'f9.5', 'sigma, mm|x')
        call table%column('sigma_y_mm', 'f9.5', '|y')
        call table%column('sigma_z_mm', 'f9.5', '|z')
        do i = 1, size(programme%chosen)
            associate (candidate => candidates(programme%chosen(i)))
                call table%add(nint(candidate%time))
                call table%add([candidate%duration, candidate%latitude/DEGREE, candidate%longitude/DEGREE])
            end associate
            do axis = 1, 3
                if (programme%sigma(axis, i) < UNSEEN) then
                    call table%add([programme%sigma(axis, i)/MILLIMETRE])
                else
                    call table%add_nothing()
                end if
            end do
        end do
    end function table_of
end module gracecg_cli_programme
